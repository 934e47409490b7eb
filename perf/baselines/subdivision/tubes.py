"""A coarse closed mesh of square tubes round centrelines, joined at branchings."""

import numpy as np

from .centreline import Branch, Centrelines

FULLNESS = 1.06  # of a section of voxels, over the largest ball in it
TOLERANCE = 0.5  # of a line that skips rings, in voxels
LONGEST = 4  # distance of rings, in radii
CLOSEST = 0.75  # the same
CAP_HEIGHT, CAP_RADIUS = 0.6, 0.8  # of the last ring of a round end, in the end's radii


class QuadMesh:
    """Quadrilaterals, counter-clockwise seen from outside. Closed after every step."""

    def __init__(self) -> None:
        self.vertices: list[np.ndarray] = []
        self.quads: dict[int, tuple[int, int, int, int]] = {}
        self.tips: dict[int, np.ndarray] = {}  # of quads that are round ends
        self.next_quad = 0

    def add_quad(self, corners: tuple[int, int, int, int]) -> int:
        self.quads[self.next_quad] = corners
        self.next_quad += 1
        return self.next_quad - 1

    def middle(self, quad: int) -> np.ndarray:
        return np.mean([self.vertices[v] for v in self.quads[quad]], axis=0)

    def normal(self, quad: int) -> np.ndarray:
        a, b, c, d = (self.vertices[v] for v in self.quads[quad])
        normal = np.cross(c - a, d - b)
        return normal / max(np.linalg.norm(normal), 1e-12)

    def bridge(self, one: int, other: int) -> bool:
        """Takes two quads away and joins their borders by four new ones, the shortest way; false
        where they touch."""
        a, b = self.quads[one], self.quads[other]
        if set(a) & set(b):
            return False

        def partner(shift: int, k: int) -> int:
            return b[(shift - k) % 4]

        def span(shift: int) -> float:
            return sum(float(np.linalg.norm(self.vertices[a[k]] - self.vertices[partner(shift, k)]))
                       for k in range(4))

        shift = min(range(4), key=span)
        del self.quads[one], self.quads[other]
        for k in range(4):
            self.add_quad((a[k], a[(k + 1) % 4], partner(shift, k + 1), partner(shift, k)))
        return True

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and triangles, each quad cut along its shorter diagonal, or round its tip."""
        vertices = np.array(self.vertices + list(self.tips.values()))
        tips = {quad: len(self.vertices) + i for i, quad in enumerate(self.tips)}
        triangles = []
        for quad, (a, b, c, d) in self.quads.items():
            if quad in tips:
                tip = tips[quad]
                triangles += [(a, b, tip), (b, c, tip), (c, d, tip), (d, a, tip)]
            elif np.linalg.norm(vertices[a] - vertices[c]) <= np.linalg.norm(vertices[b] - vertices[d]):
                triangles += [(a, b, c), (a, c, d)]
            else:
                triangles += [(a, b, d), (b, c, d)]
        used, numbers = np.unique(np.array(triangles), return_inverse=True)
        return vertices[used], numbers.reshape(-1, 3)


class Tube:
    """The rings of one branch in a mesh, and its faces."""

    def __init__(self, mesh: QuadMesh, points: np.ndarray, radii: np.ndarray,
                 tips: list[np.ndarray | None]) -> None:
        self.sides: list[int] = []
        rings = [self.add_ring(mesh, p, u, v, r)
                 for p, (u, v), r in zip(points, frames_along(points), radii)]
        for low, high in zip(rings, rings[1:]):
            for k in range(4):
                j = (k + 1) % 4
                self.sides.append(mesh.add_quad((low[k], low[j], high[j], high[k])))
        first, last = rings[0], rings[-1]
        self.start = mesh.add_quad((first[3], first[2], first[1], first[0]))
        self.end = mesh.add_quad((last[0], last[1], last[2], last[3]))
        for quad, tip in zip((self.start, self.end), tips):
            if tip is not None:
                mesh.tips[quad] = tip

    @staticmethod
    def add_ring(mesh: QuadMesh, p: np.ndarray, u: np.ndarray, v: np.ndarray,
                 radius: float) -> list[int]:
        first = len(mesh.vertices)
        for way in (u, v, -u, -v):
            mesh.vertices.append(p + FULLNESS * radius * way)
        return list(range(first, first + 4))


def tangents_along(points: np.ndarray) -> np.ndarray:
    steps = np.gradient(points, axis=0)
    return steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)


def frames_along(points: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Two directions across the line at each point, turned no more than it turns."""
    tangents = tangents_along(points)
    u = np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])
    frames = []
    for tangent in tangents:
        u = u - np.dot(u, tangent) * tangent
        u = u / np.linalg.norm(u)
        frames.append((u, np.cross(tangent, u)))
    return frames


def needed_points(line: np.ndarray, keep: set[int], tolerance: float, longest: float) -> list[int]:
    """Points (position and radius, mm) that describe a line within the tolerance: Douglas and
    Peucker's way, between those to keep, at most so many radii apart."""
    chosen = sorted(keep | {0, len(line) - 1})
    todo = list(zip(chosen, chosen[1:]))
    while todo:
        low, high = todo.pop()
        if high - low < 2:
            continue
        part = line[low:high + 1]
        chord = part[-1] - part[0]
        along = (part - part[0]) @ chord / max(float(chord @ chord), 1e-12)
        off = np.linalg.norm(part - part[0] - np.clip(along, 0, 1)[:, None] * chord, axis=1)
        worst = int(np.argmax(off))
        reach = float(np.linalg.norm(chord[:3]))
        if reach < 2 * CLOSEST * float(part[:, 3].mean()):
            continue
        if off[worst] <= tolerance:
            if reach <= longest * float(part[:, 3].mean()):
                continue
            worst = len(part) // 2
        worst = min(max(worst, 1), len(part) - 2)
        chosen.append(low + worst)
        todo += [(low, low + worst), (low + worst, high)]
    return sorted(set(chosen))


def start_outside(branch: Branch, parent: Branch, goes_on: bool) -> int:
    """The first point of a branch that lies outside the parent's tube, or a radius on where it goes
    on from the parent's start; the last but one at most."""
    last = max(len(branch.points) - 2, 0)
    if goes_on:
        away = np.linalg.norm(branch.points - parent.points[0], axis=1)
        return min(int(np.argmax(away > branch.radii[0])), last)
    axis = parent.points
    for i, point in enumerate(branch.points):
        away = np.linalg.norm(axis - point, axis=1)
        nearest = int(np.argmin(away))
        if away[nearest] > parent.radii[nearest] + 0.5 * branch.radii[i]:
            return min(i, last)
    return last


def extended(points: np.ndarray, radii: np.ndarray, low: bool, high: bool) -> tuple:
    """The line with a ring of each free end's round cap before and after it, and the two tips."""
    tangents = tangents_along(points) if len(points) > 1 else np.array([[1.0, 0, 0]])
    ends = [points[0] - radii[0] * tangents[0], points[-1] + radii[-1] * tangents[-1]]
    before = points[:1] - CAP_HEIGHT * radii[0] * tangents[:1]
    after = points[-1:] + CAP_HEIGHT * radii[-1] * tangents[-1:]
    points = np.vstack([before[:low], points, after[:high]])
    radii = np.concatenate([CAP_RADIUS * radii[:1][:low], radii, CAP_RADIUS * radii[-1:][:high]])
    return points, radii, [ends[0] if low else None, ends[1] if high else None]


def windows_of(branches: list[Branch], children: list[int], number: int) -> set[int]:
    """Points of a branch that get rings before and after each child, so that a side fits it."""
    points = branches[number].points
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    keep: set[int] = set()
    for child in children:
        at = along[branches[child].parent_point]
        width = max(float(branches[child].radii[min(3, len(branches[child].radii) - 1)]), 1e-6)
        for edge in (at - width, at + width):
            keep.add(int(np.argmin(np.abs(along - edge))))
    return keep


def facing(mesh: QuadMesh, tube: Tube, target: np.ndarray) -> int | None:
    """The free side of a tube that looks at a place the most."""
    def score(quad: int) -> float:
        way = target - mesh.middle(quad)
        distance = max(float(np.linalg.norm(way)), 1e-12)
        return float(mesh.normal(quad) @ way) / distance - 0.02 * distance / voxel_of(mesh, quad)

    free = [quad for quad in tube.sides if quad in mesh.quads]
    near = sorted(free, key=lambda q: float(np.linalg.norm(mesh.middle(q) - target)))[:12]
    return max(near, key=score, default=None)


def voxel_of(mesh: QuadMesh, quad: int) -> float:
    """A length of the quad's size."""
    a, _, c, _ = (mesh.vertices[v] for v in mesh.quads[quad])
    return max(float(np.linalg.norm(c - a)), 1e-12)


def starts_at_end(lines: Centrelines, number: int) -> bool:
    """Whether a branch goes on from the very start of its parent, the root of a piece."""
    branch = lines.branches[number]
    return branch.parent >= 0 and branch.parent_point == 0 and lines.branches[branch.parent].parent < 0


def make_tube(mesh: QuadMesh, lines: Centrelines, number: int, looped: set[tuple[int, int]],
              voxel: float) -> Tube:
    branch = lines.branches[number]
    children = [i for i, b in enumerate(lines.branches) if b.parent == number]
    first = 0
    if branch.parent >= 0:
        first = start_outside(branch, lines.branches[branch.parent], starts_at_end(lines, number))
    line = np.column_stack([branch.points, branch.radii])[first:]
    keep = {k - first for k in windows_of(lines.branches, children, number) if k > first}
    chosen = needed_points(line, keep, TOLERANCE * voxel, LONGEST)
    free_start = branch.parent < 0 and (number, 0) not in looped and not any(
        starts_at_end(lines, child) for child in children)
    free_end = (number, len(branch.points) - 1) not in looped
    return Tube(mesh, *extended(line[chosen, :3], line[chosen, 3], free_start, free_end))


def join_to_parent(mesh: QuadMesh, lines: Centrelines, tubes: list[Tube], number: int) -> None:
    parent, tube = tubes[lines.branches[number].parent], tubes[number]
    face = parent.start if starts_at_end(lines, number) else None
    if face not in mesh.quads:
        face = facing(mesh, parent, mesh.middle(tube.start))
    if face is not None:
        mesh.bridge(face, tube.start)


def tube_mesh(lines: Centrelines, voxel: float) -> QuadMesh:
    """The closed mesh of all branches. A join that finds no free side is left out: the branch is
    then a piece of its own."""
    mesh = QuadMesh()
    tubes: list[Tube] = []
    looped = {place for loop in lines.loops for place in loop}
    for number in range(len(lines.branches)):
        tubes.append(make_tube(mesh, lines, number, looped, voxel))
        parent = lines.branches[number].parent
        if parent >= 0:
            join_to_parent(mesh, lines, tubes, number)
    for one, other in lines.loops:
        close_loop(mesh, lines, tubes, one, other)
    return mesh


def close_loop(mesh: QuadMesh, lines: Centrelines, tubes: list[Tube], one: tuple[int, int],
               other: tuple[int, int]) -> None:
    """Joins two places: by the caps of branches that end there, else by sides."""
    faces = []
    for (number, point), (to_number, to_point) in ((one, other), (other, one)):
        branch, tube = lines.branches[number], tubes[number]
        target = lines.branches[to_number].points[to_point]
        if point >= len(branch.points) - 2 and tube.end in mesh.quads:
            faces.append(tube.end)
        elif point <= 1 and tube.start in mesh.quads:
            faces.append(tube.start)
        else:
            faces.append(facing(mesh, tube, target))
    if None not in faces and faces[0] != faces[1]:
        mesh.bridge(faces[0], faces[1])

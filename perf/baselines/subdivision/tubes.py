"""A coarse closed mesh of square tubes round centrelines, joined at branchings."""

import numpy as np

from .centreline import Branch, Centrelines
from .quads import QuadMesh
from .rings import extended, frames_along, needed_points

FULLNESS = 1.06  # of a section of voxels, over the largest ball in it
NEAREST = 12  # sides among which a branch finds the one to leave from
FARNESS = 0.02  # what a distance of its size takes from the cosine of a side's normal


class Tube:
    """The rings of one branch in a mesh, and its faces."""

    def __init__(
        self, mesh: QuadMesh, points: np.ndarray, radii: np.ndarray, tips: list[np.ndarray | None]
    ) -> None:
        self.sides: list[int] = []
        rings = [
            self.add_ring(mesh, p, u, v, r)
            for p, (u, v), r in zip(points, frames_along(points), radii)
        ]
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
    def add_ring(
        mesh: QuadMesh, p: np.ndarray, u: np.ndarray, v: np.ndarray, radius: float
    ) -> list[int]:
        first = len(mesh.vertices)
        for way in (u, v, -u, -v):
            mesh.vertices.append(p + FULLNESS * radius * way)
        return list(range(first, first + 4))


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
    """The free side of a tube that looks at a place the most, of those near to it."""

    def score(quad: int) -> float:
        way = target - mesh.middle(quad)
        distance = max(float(np.linalg.norm(way)), 1e-12)
        return float(mesh.normal(quad) @ way) / distance - FARNESS * distance / mesh.size(quad)

    free = [quad for quad in tube.sides if quad in mesh.quads]
    near = sorted(free, key=lambda q: float(np.linalg.norm(mesh.middle(q) - target)))[:NEAREST]
    return max(near, key=score, default=None)


def starts_at_end(lines: Centrelines, number: int) -> bool:
    """Whether a branch goes on from the very start of its parent, the root of a piece."""
    branch = lines.branches[number]
    at_start = branch.parent >= 0 and branch.parent_point == 0
    return at_start and lines.branches[branch.parent].parent < 0


def make_tube(
    mesh: QuadMesh, lines: Centrelines, number: int, looped: set[tuple[int, int]], voxel: float
) -> Tube:
    branch = lines.branches[number]
    children = [i for i, b in enumerate(lines.branches) if b.parent == number]
    first = 0
    if branch.parent >= 0:
        first = start_outside(branch, lines.branches[branch.parent], starts_at_end(lines, number))
    line = np.column_stack([branch.points, branch.radii])[first:]
    keep = {k - first for k in windows_of(lines.branches, children, number) if k > first}
    chosen = needed_points(line, keep, voxel)
    free_start = (
        branch.parent < 0
        and (number, 0) not in looped
        and not any(starts_at_end(lines, child) for child in children)
    )
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


def close_loop(
    mesh: QuadMesh,
    lines: Centrelines,
    tubes: list[Tube],
    one: tuple[int, int],
    other: tuple[int, int],
) -> None:
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

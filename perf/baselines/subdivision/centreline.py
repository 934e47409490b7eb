"""Centrelines of a segmentation as branches of points with radii."""

from dataclasses import dataclass, field

import numpy as np
from scipy import ndimage, sparse
from scipy.sparse import csgraph
from skimage.morphology import skeletonize

SMOOTHING = 3  # standard deviation along a centreline, in its voxels
TIP = 6  # voxels of a line that tell where it ends
LEAST_LOOP = 10  # voxels round: shorter ones are corners of the thinning


@dataclass
class Branch:
    """From its start on the parent's centreline, or its own end, to its tip."""

    points: np.ndarray  # n x 3, mm along the volume's axes
    radii: np.ndarray  # n, mm
    parent: int = -1  # branch that it starts on; -1: none
    parent_point: int = 0


@dataclass
class Centrelines:
    branches: list[Branch] = field(default_factory=list)
    loops: list[tuple[tuple[int, int], tuple[int, int]]] = field(default_factory=list)
    """Places, (branch, point) each, that a line joins to a loop."""


def skeleton_of(volume: np.ndarray, spacing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices (n x 3) of the thinned object and the radii there, mm.

    The distance is that to the nearest centre of background: just outside a thick vessel, half the
    smallest spacing outside a line of voxels. The largest one round a voxel is taken, since
    thinning leaves the middle by up to a voxel.
    """
    padded = np.pad(volume, 1)
    depth = ndimage.distance_transform_edt(padded, sampling=spacing)
    depth = ndimage.maximum_filter(depth, size=3)
    indices = np.argwhere(skeletonize(padded))
    found = depth[tuple(indices.T)]
    return indices - 1, found - 0.5 * float(spacing.min()) ** 2 / found


def neighbour_graph(indices: np.ndarray, spacing: np.ndarray) -> sparse.csr_matrix:
    """Which voxels of a skeleton touch, weighted by their distance in mm."""
    number = {tuple(index): i for i, index in enumerate(indices)}
    rows, columns, lengths = [], [], []
    offsets = [np.array(o) - 1 for o in np.ndindex(3, 3, 3) if o > (1, 1, 1)]
    for i, index in enumerate(indices):
        for offset in offsets:
            other = number.get(tuple(index + offset))
            if other is not None:
                rows.append(i)
                columns.append(other)
                lengths.append(float(np.linalg.norm(offset * spacing)))
    count = len(indices)
    half = sparse.coo_matrix((lengths, (rows, columns)), shape=(count, count))
    return (half + half.T).tocsr()


def spanning_forest(graph: sparse.csr_matrix, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each voxel's parent (-1: a root) and distance along the tree from its piece's end that is
    farthest from its thickest voxel."""
    _, pieces = csgraph.connected_components(graph, directed=False)
    parents = np.full(len(radii), -1)
    distances = np.zeros(len(radii))
    for piece in range(pieces.max() + 1):
        members = np.flatnonzero(pieces == piece)
        inside = graph[members][:, members]
        thickest = int(np.argmax(radii[members]))
        root = int(np.argmax(csgraph.dijkstra(inside, directed=False, indices=thickest)))
        along, before = csgraph.dijkstra(
            inside, directed=False, indices=root, return_predecessors=True
        )
        distances[members] = along
        parents[members] = np.where(before < 0, -1, members[np.maximum(before, 0)])
    return parents, distances


def paths_of(parents: np.ndarray, distances: np.ndarray) -> list[list[int]]:
    """The forest cut into paths, each the longest way on; all but a root's begin with the voxel of
    the path that they leave."""
    reach = distances.copy()
    heir = np.full(len(parents), -1)
    for voxel in np.argsort(-distances, kind="stable"):
        parent = parents[voxel]
        if parent >= 0 and (heir[parent] < 0 or reach[voxel] > reach[parent]):
            heir[parent] = voxel
            reach[parent] = reach[voxel]
    paths = []
    for voxel in np.argsort(distances, kind="stable"):
        parent = parents[voxel]
        if parent >= 0 and heir[parent] == voxel:
            continue
        path = [int(voxel)] if parent < 0 else [int(parent), int(voxel)]
        while heir[path[-1]] >= 0:
            path.append(int(heir[path[-1]]))
        paths.append(path)
    return paths


def loop_edges(
    graph: sparse.csr_matrix,
    parents: np.ndarray,
    distances: np.ndarray,
    radii: np.ndarray,
    voxel: float,
) -> list[tuple[int, int]]:
    """Edges beside the forest that close a loop of some size, one a loop."""
    upper = sparse.triu(graph).tocoo()
    found: list[tuple[int, int]] = []
    for a, b in zip(upper.row.tolist(), upper.col.tolist()):
        if parents[a] == b or parents[b] == a:
            continue
        least = max(LEAST_LOOP * voxel, 4 * (radii[a] + radii[b]))
        if loop_length(parents, distances, a, b) < least:
            continue
        near = {n for v in (a, b) for n in graph[v].indices} | {a, b}
        if not any(c in near or d in near for c, d in found):
            found.append((a, b))
    return found


def loop_length(parents: np.ndarray, distances: np.ndarray, a: int, b: int) -> float:
    """Of the way along the tree from a to b, mm."""
    total = distances[a] + distances[b]
    while a != b:
        if distances[a] < distances[b] or (distances[a] == distances[b] and a < b):
            a, b = b, a
        a = int(parents[a])
    return float(total - 2 * distances[a])


def smoothed(points: np.ndarray, fixed: bool) -> np.ndarray:
    """Gaussian along the line; the ends stay, the first alone where it lies on another branch."""
    if len(points) < 4:
        return points
    smooth = ndimage.gaussian_filter1d(points, SMOOTHING, axis=0, mode="nearest")
    smooth[-1] = points[-1]
    if fixed:
        smooth[0] = points[0]
    return smooth


def to_tip(
    points: np.ndarray, radius: float, volume: np.ndarray, spacing: np.ndarray
) -> np.ndarray:
    """The line drawn on to the centre of the vessel's round end, which thinning has cut off."""
    way = points[-1] - points[-min(len(points), TIP)]
    length = float(np.linalg.norm(way))
    if length == 0:
        return points
    step = way / length * float(spacing.min()) / 2
    end = points[-1]
    while inside(volume, (end + step) / spacing):
        end = end + step
    beyond = float(np.linalg.norm(end - points[-1])) - radius
    return np.vstack([points, points[-1] + beyond * way / length]) if beyond > 0 else points


def inside(volume: np.ndarray, place: np.ndarray) -> bool:
    index = np.round(place).astype(int)
    return bool(np.all(index >= 0) and np.all(index < volume.shape) and volume[tuple(index)])


def centrelines(volume: np.ndarray, spacing: np.ndarray) -> Centrelines:
    """Of every piece of a binary volume, its axes in the order of the spacings."""
    indices, depth = skeleton_of(volume, spacing)
    voxel = float(np.prod(spacing)) ** (1 / 3)
    radii = np.maximum(depth, 0.5 * voxel)
    graph = neighbour_graph(indices, spacing)
    parents, distances = spanning_forest(graph, radii)
    edges = loop_edges(graph, parents, distances, radii, voxel)
    in_loop = {v for edge in edges for v in edge}
    result = Centrelines()
    place: dict[int, tuple[int, int]] = {}
    for path in paths_of(parents, distances):
        is_child = parents[path[0]] >= 0 or path[0] in place
        if is_child and path[0] not in place:
            continue  # on a spur
        length = distances[path[-1]] - distances[path[0]]
        if is_child and length < radii[path[0]] + radii[path[-1]] and not in_loop & set(path):
            continue  # a spur inside the parent's tube
        branch = Branch(smoothed(indices[path] * spacing, is_child), smoothed(radii[path], False))
        if is_child:
            branch.parent, branch.parent_point = place[path[0]]
        elif length < radii[path[0]]:  # a ball
            branch = Branch(branch.points.mean(axis=0)[None], radii[path].max()[None])
        for i, v in enumerate(path):
            place.setdefault(v, (len(result.branches), min(i, len(branch.points) - 1)))
        result.branches.append(branch)
    result.loops = [(place[a], place[b]) for a, b in edges if a in place and b in place]
    draw_on(result, volume, spacing)
    return result


def draw_on(lines: Centrelines, volume: np.ndarray, spacing: np.ndarray) -> None:
    """Takes every end that is no part of a loop to the vessel's end."""
    looped = {place for loop in lines.loops for place in loop}
    for number, branch in enumerate(lines.branches):
        if (number, len(branch.points) - 1) not in looped:
            grow(branch, to_tip(branch.points, branch.radii[-1], volume, spacing), False)
        joined = any(b.parent == number and b.parent_point == 0 for b in lines.branches)
        if branch.parent < 0 and not joined and (number, 0) not in looped:
            back = to_tip(branch.points[::-1], branch.radii[0], volume, spacing)[::-1]
            added = len(back) - len(branch.points)
            for child in lines.branches:
                child.parent_point += added if child.parent == number else 0
            lines.loops = [
                tuple((n, p + added if n == number else p) for n, p in loop) for loop in lines.loops
            ]
            grow(branch, back, True)


def grow(branch: Branch, points: np.ndarray, low: bool) -> None:
    added = len(points) - len(branch.points)
    branch.points = points
    branch.radii = np.pad(branch.radii, (added, 0) if low else (0, added), mode="edge")

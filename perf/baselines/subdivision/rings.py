"""Where along a centreline the rings of its tube lie."""

import numpy as np

TOLERANCE = 0.5  # of a line that skips rings, in voxels
LONGEST = 4  # distance of rings, in radii
CLOSEST = 0.75  # the same
CAP_HEIGHT, CAP_RADIUS = 0.6, 0.8  # of the last ring of a round end, in the end's radii


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


def needed_points(line: np.ndarray, keep: set[int], voxel: float) -> list[int]:
    """Points of a line (position and radius, mm) whose polygon stays within the tolerance: Douglas
    and Peucker's way between those to keep, neither too close nor too far apart."""
    chosen = sorted(keep | {0, len(line) - 1})
    todo = list(zip(chosen, chosen[1:]))
    while todo:
        low, high = todo.pop()
        middle = split_of(line[low : high + 1], voxel)
        if middle:
            chosen.append(low + middle)
            todo += [(low, low + middle), (low + middle, high)]
    return sorted(set(chosen))


def split_of(part: np.ndarray, voxel: float) -> int:
    """The point where a part of a line needs a ring; 0: it needs none."""
    chord = part[-1] - part[0]
    reach, radius = float(np.linalg.norm(chord[:3])), float(part[:, 3].mean())
    if len(part) < 3 or reach < 2 * CLOSEST * radius:
        return 0
    along = (part - part[0]) @ chord / max(float(chord @ chord), 1e-12)
    off = np.linalg.norm(part - part[0] - np.clip(along, 0, 1)[:, None] * chord, axis=1)
    if off.max() > TOLERANCE * voxel:
        return min(max(int(np.argmax(off)), 1), len(part) - 2)
    return len(part) // 2 if reach > LONGEST * radius else 0


def extended(points: np.ndarray, radii: np.ndarray, low: bool, high: bool) -> tuple:
    """The line with a ring of each free end's round cap before and after it, and the two tips."""
    tangents = tangents_along(points) if len(points) > 1 else np.array([[1.0, 0, 0]])
    ends = [points[0] - radii[0] * tangents[0], points[-1] + radii[-1] * tangents[-1]]
    before = points[:1] - CAP_HEIGHT * radii[0] * tangents[:1]
    after = points[-1:] + CAP_HEIGHT * radii[-1] * tangents[-1:]
    points = np.vstack([before[:low], points, after[:high]])
    radii = np.concatenate([CAP_RADIUS * radii[:1][:low], radii, CAP_RADIUS * radii[-1:][:high]])
    return points, radii, [ends[0] if low else None, ends[1] if high else None]

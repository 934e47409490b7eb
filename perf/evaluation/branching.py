"""Vessel radii and a branching to look at, from the centrelines of a segmentation."""

from dataclasses import dataclass

import numpy as np
import SimpleITK as sitk
from baselines.subdivision.centreline import Centrelines, centrelines, skeleton_of

from .inputs import Input

WIDTH = 4.5  # of the view, in radii of the thicker vessel
WANTED = 3.5  # voxels: the radius of the side branch that shows the most


@dataclass(frozen=True)
class Anatomy:
    median_radius: float  # of inscribed balls along the centrelines, voxels
    place: list[float]  # a branching, mm, LPS; the thickest place where there is none
    radius: float  # of the ball round it to look at, mm


def widest_branching(lines: Centrelines, voxel: float) -> tuple[np.ndarray, float] | None:
    """Where the branch of the radius nearest to the wanted one starts, and its parent's radius."""
    found = []
    for branch in lines.branches:
        if branch.parent < 0 or len(branch.points) < 8:
            continue
        parent = lines.branches[branch.parent]
        radius = float(np.median(branch.radii))
        at = min(branch.parent_point, len(parent.points) - 1)
        found.append(
            (
                abs(radius / voxel - WANTED),
                len(found),
                parent.points[at],
                max(float(parent.radii[at]), 2 * voxel),
            )
        )
    if not found:
        return None
    _, _, place, radius = min(found, key=lambda entry: entry[:2])
    return place, radius


def anatomy(given: Input) -> Anatomy:
    image = sitk.ReadImage(str(given.volume))
    volume = sitk.GetArrayViewFromImage(image).transpose() != 0
    low, high = np.argwhere(volume).min(axis=0), np.argwhere(volume).max(axis=0) + 1
    part = volume[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    spacing = np.array(image.GetSpacing())
    voxel = float(np.prod(spacing)) ** (1 / 3)
    indices, radii = skeleton_of(part, spacing)
    branching = widest_branching(centrelines(part, spacing), voxel)
    thickest = int(np.argmax(radii))
    place, radius = branching or (indices[thickest] * spacing, float(radii[thickest]))
    direction = np.array(image.GetDirection()).reshape(3, 3)
    lps = direction @ (place + low * spacing) + np.array(image.GetOrigin())
    return Anatomy(float(np.median(radii)) / voxel, lps.tolist(), WIDTH * radius)

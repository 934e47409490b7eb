"""Vessel radii and a branching to look at, from the centrelines of a segmentation."""

from dataclasses import dataclass
from pathlib import Path

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


@dataclass(frozen=True)
class Object:
    """The voxels that are not 0, cut out of the volume."""

    image: sitk.Image
    voxels: np.ndarray  # axes in the order of the spacings
    low: np.ndarray  # index of the first one cut out
    spacing: np.ndarray  # mm

    @property
    def voxel(self) -> float:
        return float(np.prod(self.spacing)) ** (1 / 3)


def read_object(path: Path) -> Object:
    image = sitk.ReadImage(str(path))
    volume = sitk.GetArrayViewFromImage(image).transpose() != 0
    low, high = np.argwhere(volume).min(axis=0), np.argwhere(volume).max(axis=0) + 1
    part = volume[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    return Object(image, part, low, np.array(image.GetSpacing()))


def median_radius(path: Path) -> float:
    """Of inscribed balls along a segmentation's centrelines, voxels."""
    found = read_object(path)
    return float(np.median(skeleton_of(found.voxels, found.spacing)[1])) / found.voxel


def anatomy(given: Input) -> Anatomy:
    found = read_object(given.volume)
    indices, radii = skeleton_of(found.voxels, found.spacing)
    branching = widest_branching(centrelines(found.voxels, found.spacing), found.voxel)
    thickest = int(np.argmax(radii))
    place, radius = branching or (indices[thickest] * found.spacing, float(radii[thickest]))
    direction = np.array(found.image.GetDirection()).reshape(3, 3)
    lps = direction @ (place + found.low * found.spacing) + np.array(found.image.GetOrigin())
    return Anatomy(float(np.median(radii)) / found.voxel, lps.tolist(), WIDTH * radius)

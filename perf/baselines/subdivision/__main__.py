"""python -m baselines.subdivision VOLUME SURFACE.ply: see the package."""

import argparse
from pathlib import Path

import numpy as np
import SimpleITK as sitk
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersModeling import vtkLoopSubdivisionFilter
from vtkmodules.vtkIOPLY import vtkPLYWriter

from .centreline import centrelines
from .loop import interpolating
from .tubes import tube_mesh

ITERATIONS = 3


def to_vtk(vertices: np.ndarray, triangles: np.ndarray) -> vtkPolyData:
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices, dtype=np.float32), deep=True))
    cells = vtkCellArray()
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(triangles.ravel().astype(np.int64), deep=True),
    )
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    return data


def subdivision_surface(image: sitk.Image) -> vtkPolyData:
    """The surface round the voxels other than 0, in mm, LPS."""
    volume = sitk.GetArrayViewFromImage(image).transpose() != 0
    low, high = np.argwhere(volume).min(axis=0), np.argwhere(volume).max(axis=0) + 1
    part = volume[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    spacing = np.array(image.GetSpacing())
    mesh = tube_mesh(centrelines(part, spacing), float(np.prod(spacing)) ** (1 / 3))
    vertices, triangles = mesh.triangles()
    direction = np.array(image.GetDirection()).reshape(3, 3)
    vertices = (interpolating(vertices, triangles) + low * spacing) @ direction.T + np.array(
        image.GetOrigin()
    )
    if np.linalg.det(direction) < 0:
        triangles = triangles[:, ::-1]
    subdivision = vtkLoopSubdivisionFilter()
    subdivision.SetInputData(to_vtk(vertices, triangles))
    subdivision.SetNumberOfSubdivisions(ITERATIONS)
    subdivision.Update()
    return subdivision.GetOutput()


def main() -> None:
    parser = argparse.ArgumentParser(prog="subdivision", description=__doc__)
    parser.add_argument("volume", type=Path)
    parser.add_argument("surface", type=Path)
    arguments = parser.parse_args()
    surface = subdivision_surface(sitk.ReadImage(str(arguments.volume)))
    if surface.GetNumberOfCells() == 0:
        raise SystemExit("the mesh of tubes is no manifold: it cannot be subdivided")
    writer = vtkPLYWriter()
    writer.SetInputData(surface)
    writer.SetFileName(str(arguments.surface))
    writer.Write()


if __name__ == "__main__":
    main()

"""Surfaces with the library's figures on them (`vasamesh check --map`), read through VTK."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOLegacy import vtkPolyDataReader
from vtkmodules.vtkIOPLY import vtkPLYWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

KEPT = 64  # bins of a histogram


@dataclass(frozen=True)
class SurfaceMap:
    vertices: np.ndarray  # n x 3, mm
    triangles: np.ndarray  # m x 3
    rms_curvature: np.ndarray  # n, 1/mm
    area: np.ndarray  # n, mm^2
    edge_ratio: np.ndarray  # m
    least_angle: np.ndarray  # m, degrees


def read_map(path: Path) -> SurfaceMap:
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    points, cells = data.GetPointData(), data.GetCellData()
    return SurfaceMap(
        vtk_to_numpy(data.GetPoints().GetData()).copy(),
        vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3).copy(),
        vtk_to_numpy(points.GetArray("rms_curvature")).copy(),
        vtk_to_numpy(points.GetArray("area")).copy(),
        vtk_to_numpy(cells.GetArray("edge_ratio")).copy(),
        vtk_to_numpy(cells.GetArray("least_angle")).copy(),
    )


def to_lps(given: Path, copy: Path) -> None:
    """A legacy VTK surface in RAS as PLY in LPS."""
    reader = vtkPolyDataReader()
    reader.SetFileName(str(given))
    reader.Update()
    data = reader.GetOutput()
    points = vtk_to_numpy(data.GetPoints().GetData())  # the reader's own memory
    points[:, :2] *= -1
    writer = vtkPLYWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(copy))
    writer.Write()


def in_ball(surface: SurfaceMap, centre: np.ndarray, radius: float) -> np.ndarray:
    """Which triangles have a corner in the ball."""
    near = np.linalg.norm(surface.vertices - centre, axis=1) <= radius
    return near[surface.triangles].any(axis=1)


def histograms(surface: SurfaceMap, curvature_limit: float) -> dict[str, list[float]]:
    """Shares in equal bins: of the area by RMS curvature, 0 to the limit and beyond (in the last
    one), and of the triangles by edge ratio (0 to 1) and least angle (0 to 60)."""
    curvature = np.minimum(surface.rms_curvature, curvature_limit * (1 - 1e-6))
    found = {
        "rms_curvature": (curvature, curvature_limit, surface.area),
        "edge_ratio": (surface.edge_ratio, 1.0, None),
        "least_angle": (surface.least_angle, 60.0, None),
    }
    shares = {}
    for name, (values, limit, weights) in found.items():
        counts, _ = np.histogram(values, KEPT, (0, limit), weights=weights)
        shares[name] = [float(f"{c:.4g}") for c in counts / max(counts.sum(), 1e-30)]
    return shares

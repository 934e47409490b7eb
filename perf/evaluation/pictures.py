"""Pictures: histograms by matplotlib, coloured surfaces by PyVista."""

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pyvista
from PIL import Image

from .surfaces import KEPT, SurfaceMap, in_ball

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  after the choice of what it draws with

TILE = (360, 300)  # pixels
COLUMNS = 3
COLOURS = 80
CURVATURE_COLOURS = "turbo"
VESSEL, EDGE = "#e2a58f", "#40201a"
FRONT = np.array([0.0, -1.0, 0.0])  # from the surface to the eye
AXES = (
    ("rms_curvature", "RMS curvature, 1/mm", "share of the area"),
    ("edge_ratio", "edge ratio", "share of the triangles"),
    ("least_angle", "least angle, degrees", "share of the triangles"),
)


def draw_histograms(
    shares: dict[str, dict[str, list[float]]], curvature_limit: float, path: Path
) -> None:
    """One plot a figure, one line a method."""
    limits = {"rms_curvature": curvature_limit, "edge_ratio": 1.0, "least_angle": 60.0}
    figure, axes = pyplot.subplots(1, 3, figsize=(12, 3.4))
    for axis, (name, title, share) in zip(axes, AXES):
        edges = np.linspace(0, limits[name], KEPT + 1)
        for method, found in shares.items():
            axis.stairs(found[name], edges, label=method, linewidth=1.6 if method == "ours" else 1)
        axis.set_xlabel(title)
        axis.set_ylabel(share)
    axes[0].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    pyplot.close(figure)
    reduce_colours(path)


def reduce_colours(path: Path) -> None:
    """The same picture in a palette: a third of the bytes."""
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    small.save(path, optimize=True)


def poly_data(surface: SurfaceMap, chosen: np.ndarray | None = None) -> pyvista.PolyData:
    triangles = surface.triangles if chosen is None else surface.triangles[chosen]
    cells = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    data = pyvista.PolyData(surface.vertices, cells)
    data["RMS curvature, 1/mm"] = surface.rms_curvature
    return data


def tiles(names: list[str]) -> pyvista.Plotter:
    columns = min(COLUMNS, len(names))
    rows = -(-len(names) // columns)
    return pyvista.Plotter(
        off_screen=True,
        shape=(rows, columns),
        border=False,
        window_size=(TILE[0] * columns, TILE[1] * rows),
    )


def look(limit: float | None) -> dict[str, Any]:
    """How a surface is drawn: by the RMS curvature from 0 to the limit, or with its edges."""
    if limit is None:
        return {"color": VESSEL, "show_edges": True, "edge_color": EDGE, "line_width": 1}
    return {"clim": (0, limit), "cmap": CURVATURE_COLOURS}


def save(plotter: pyvista.Plotter, path: Path) -> None:
    plotter.set_background("white", all_renderers=True)
    plotter.screenshot(path)
    plotter.close()
    reduce_colours(path)


def draw_whole(surfaces: dict[str, SurfaceMap], limit: float, path: Path) -> None:
    """The surfaces seen from the front, coloured."""
    plotter = tiles(list(surfaces))
    for i, (name, surface) in enumerate(surfaces.items()):
        plotter.subplot(i // COLUMNS, i % COLUMNS)
        plotter.add_text(name, font_size=9, color="black")
        last = i == len(surfaces) - 1
        plotter.add_mesh(poly_data(surface), show_scalar_bar=last, **look(limit))
        plotter.view_vector(tuple(FRONT), (0, 0, 1))
        plotter.camera.zoom(1.35)
    save(plotter, path)


def draw_close(
    surfaces: dict[str, SurfaceMap],
    centre: np.ndarray,
    radius: float,
    limit: float | None,
    path: Path,
) -> None:
    """The triangles of each surface in a ball."""
    plotter = tiles(list(surfaces))
    for i, (name, surface) in enumerate(surfaces.items()):
        plotter.subplot(i // COLUMNS, i % COLUMNS)
        plotter.add_text(name, font_size=9, color="black")
        chosen = in_ball(surface, centre, radius)
        if chosen.any():
            plotter.add_mesh(poly_data(surface, chosen), show_scalar_bar=False, **look(limit))
        plotter.camera.focal_point = centre
        plotter.camera.position = centre + 10 * radius * FRONT
        plotter.camera.up = (0, 0, 1)
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 0.8 * radius
        plotter.reset_camera_clipping_range()
    save(plotter, path)


def draw_sweep(sweep: dict[str, Any], path: Path) -> None:
    """Triangles, error and shape against each of the constants that is a number."""
    names = [
        name
        for name, runs in sweep["constants"].items()
        if all(isinstance(run["value"], (int, float)) for run in runs)
    ]
    figures = (
        ("triangles", "triangles"),
        ("mean_voxels", "mean distance, voxels"),
        ("above_08", "edge ratio of 0.8 and above"),
    )
    figure, axes = pyplot.subplots(
        len(figures), len(names), figsize=(3 * len(names), 6), squeeze=False, sharey="row"
    )
    for column, name in enumerate(names):
        runs = [run for run in sweep["constants"][name] if run["status"] == "done"]
        for row, (key, title) in enumerate(figures):
            axes[row][column].plot([run["value"] for run in runs], [run[key] for run in runs], "o-")
            axes[row][column].set_ylim(bottom=0)
            axes[row][0].set_ylabel(title)
        axes[-1][column].set_xlabel(name)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    pyplot.close(figure)
    reduce_colours(path)

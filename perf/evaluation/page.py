"""A page of its own: tables, pictures, surfaces that turn under the mouse (three.js, inlined)."""

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from .surfaces import SurfaceMap, in_ball
from .tables import Section, html_sections

THREE = (
    Path("/usr/share/javascript/three/three.min.js"),
    Path("/usr/share/javascript/three/examples/js/controls/OrbitControls.js"),
)
TEMPLATE = Path(__file__).with_name("page.html")
STEPS = 65535  # of a coordinate over the view's box


class NoThree(Exception):
    """three.js is not here."""


def three_scripts() -> str:
    """The text of three.js and its mouse control.
    :raises NoThree: Debian's libjs-three is missing."""
    for path in THREE:
        if not path.exists():
            raise NoThree(f"{path}: no such file; install Debian's libjs-three")
    return "\n".join(path.read_text() for path in THREE)


def encoded(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()


def packed(surface: SurfaceMap, chosen: np.ndarray, limit: float) -> dict[str, Any]:
    """Some triangles as three.js takes them: positions in 16 bits, curvature in 8, indices."""
    used, numbers = np.unique(surface.triangles[chosen], return_inverse=True)
    points = surface.vertices[used].astype(np.float64)
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    places = np.round((points - low) / max(size, 1e-12) * STEPS).astype("<u2")
    colours = np.clip(surface.rms_curvature[used] / limit * 255, 0, 255).astype(np.uint8)
    kind = "<u2" if len(used) <= STEPS else "<u4"
    return {
        "low": low.tolist(),
        "size": size,
        "places": encoded(places),
        "colours": encoded(colours),
        "triangles": encoded(numbers.astype(kind)),
        "wide": kind == "<u4",
    }


def scene(
    surfaces: dict[str, SurfaceMap], place: list[float], radius: float, most: int, limit: float
) -> dict[str, Any]:
    """The surfaces of one input: whole where none has more than `most` triangles, else what of them
    lies in the ball."""
    whole = all(len(s.triangles) <= most for s in surfaces.values())
    methods = {}
    for name, surface in surfaces.items():
        chosen = (
            np.ones(len(surface.triangles), bool)
            if whole
            else in_ball(surface, np.array(place), radius)
        )
        if chosen.any():
            methods[name] = packed(surface, chosen, limit)
    return {"whole": whole, "limit": limit, "methods": methods}


def data_address(folder: Path, file: str) -> str:
    return "data:image/png;base64," + base64.b64encode((folder / file).read_bytes()).decode()


def write_page(path: Path, sections: list[Section], scenes: dict[str, Any]) -> None:
    """One file that needs no other. :raises NoThree: as three_scripts."""
    text = TEMPLATE.read_text()
    parts = {
        "@THREE@": three_scripts().replace("</script", "<\\/script"),
        "@SCENES@": json.dumps(scenes).replace("<", "\\u003c"),
        "@BODY@": html_sections(sections, lambda file: data_address(path.parent, file)),
    }
    for mark, part in parts.items():
        text = text.replace(mark, part)
    path.write_text(text)

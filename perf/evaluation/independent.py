"""The distances once more, by a tool that is not ours: PyPI's pymeshlab."""

import importlib.util
from pathlib import Path
from typing import Any

SAMPLES = 2_000_000


def available() -> bool:
    return importlib.util.find_spec("pymeshlab") is not None


def hausdorff(surface: Path, reference: Path, samples: int = SAMPLES) -> dict[str, float]:
    """Mean, RMS and largest distance from samples of the surface's faces to the reference, mm."""
    import pymeshlab  # optional

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(surface))
    meshes.load_new_mesh(str(reference))
    found = meshes.get_hausdorff_distance(
        sampledmesh=0,
        targetmesh=1,
        samplevert=False,
        sampleedge=False,
        samplefauxedge=False,
        sampleface=True,
        samplenum=samples,
        maxdist=pymeshlab.PercentageValue(100),
    )
    return {"mean_mm": found["mean"], "rms_mm": found["RMS"], "maximum_mm": found["max"]}


def sentence(name: str, row: dict[str, Any], other: dict[str, float]) -> str:
    mine = row["distance"]["to"]
    parts = [
        f"{title} {other[key]:.4f} mm ({100 * (other[key] / mine[key] - 1):+.2f} %)"
        for title, key in (("mean", "mean_mm"), ("RMS", "rms_mm"))
    ]
    return (
        f"An independent tool, pymeshlab's Hausdorff filter, from {name} to marching cubes: "
        + ", ".join(parts)
        + "."
    )

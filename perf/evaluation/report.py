"""Everything measured, and the files that show it."""

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import process
from table_text import rounded

from . import independent
from .inputs import Input
from .measure import check, measure
from .methods import METHODS
from .tables import Section, input_sections, input_table, markdown

CURVATURES = 1.5  # the scale of all pictures' curvatures, over the 95th percentile of ours

TEXT = """\
Written by `perf/compare` with {version} on a {machine}; {load:.1f} processes wanted a core on
average at the end, so that wall-clock times are those of a shared machine. A voxel as a unit is the
geometric mean of the three spacings. The best of a column is **bold**; `base` is our own surface
before it is made adaptive. Marching cubes is the reference of the distances, as in the paper, and
far from the exact surface itself."""


def anatomy_of(given: Input) -> tuple[dict[str, Any] | None, str]:
    """Radii and a branching, or why there are none."""
    try:
        from .branching import anatomy  # optional packages
    except ImportError as error:
        return None, (
            f"No Python package {error.name} here: no median radius and no close-up; see "
            "perf/requirements.txt."
        )
    return asdict(anatomy(given)), ""


def facts_of(program: Path, given: Input, folder: Path) -> dict[str, Any]:
    """The segmentation's size and topology, by way of its base surface's report."""
    report = folder / f"{given.name}_facts.json"
    outcome = process.run(
        [
            program,
            "convert",
            given.volume,
            "-o",
            folder / f"{given.name}_facts.ply",
            "--label",
            "any",
            "--surface",
            "base",
            "--quiet",
            "--report",
            report,
        ]
    )
    if outcome.code != 0:
        raise ValueError(f"{given.name}: {outcome.error.strip()}")
    content = json.loads(report.read_text())
    return {
        "name": given.name,
        "exact": "known" if given.exact else "-",
        "size": content["geometry"]["size"],
        "spacing": content["geometry"]["spacing"],
        "object_voxels": content["input"]["object_voxels"],
        "topology": content["check"]["wanted"],
        "version": content["version"],
    }


def exact_figures(program: Path, given: Input) -> dict[str, Any]:
    """What the exact surface itself has: the measure of every method."""
    report = check(program, given.exact, "--against", given.volume, "--label", "any")
    return {key: report[key] for key in ("rms_curvature", "distance")}


def evaluate(
    given: Input, methods: list[str], build: Path, folder: Path, timeout: float
) -> dict[str, Any]:
    """All methods on one input."""
    found = facts_of(build / "vasamesh", given, folder)
    place, why_not = anatomy_of(given)
    found["median_radius"] = place["median_radius"] if place else None
    found["anatomy"], found["notes"] = place, [why_not] if why_not else []
    if given.exact:
        found["exact_surface"] = exact_figures(build / "vasamesh", given)
    found["methods"] = []
    for name in methods:
        print(f"{given.name}: {METHODS[name].title}", flush=True)
        found["methods"].append(measure(name, given, build, folder, timeout))
    rows = {row["method"]: row for row in found["methods"] if row["status"] == "done"}
    found["independent"] = []
    if independent.available() and {"ours", "mc"} <= rows.keys():
        other = independent.hausdorff(
            folder / f"{given.name}_ours.ply", folder / f"{given.name}_mc.ply"
        )
        found["independent"].append(independent.sentence("ours", rows["ours"], other))
    return found


def curvature_limit(rows: dict[str, dict[str, Any]]) -> float:
    """The scale of all methods' curvatures: what ours hardly exceeds, so that roughness shows."""
    first = rows.get("ours") or next(iter(rows.values()))
    return float(f"{CURVATURES * first['rms_curvature']['percentile_95']:.2g}")


def draw_input(
    found: dict[str, Any], folder: Path, scratch: Path, most: int
) -> tuple[dict[str, str], dict[str, Any]]:
    """The pictures' file names by kind, and the page's scene. Needs the optional packages."""
    import numpy as np

    from . import page, pictures
    from .surfaces import histograms, read_map

    rows = {row["method"]: row for row in found["methods"] if row["status"] == "done"}
    if not rows:
        return {}, {}
    name, limit = found["name"], curvature_limit(rows)
    maps = {method: read_map(scratch / f"{name}_{method}.vtp") for method in rows}
    shares = {method: histograms(surface, limit) for method, surface in maps.items()}
    for method, row in rows.items():
        row["histograms"] = {"curvature_limit": limit, **shares[method]}
    files = {
        kind: f"{name}_{kind}.png"
        for kind in ("curvature", "histograms", "curvature_close", "close")
    }
    pictures.draw_whole(maps, limit, folder / files["curvature"])
    pictures.draw_histograms(shares, limit, folder / files["histograms"])
    place = found["anatomy"]
    for kind, scale in (("curvature_close", limit), ("close", None)):
        if not place:
            del files[kind]
            continue
        centre = np.array(place["place"])
        pictures.draw_close(maps, centre, place["radius"], scale, folder / files[kind])
    centre, radius = (place["place"], place["radius"]) if place else ([0, 0, 0], 1e9)
    return files, page.scene(maps, centre, radius, most, limit)


def sections_of(content: dict[str, Any], pictures: dict[str, dict[str, str]]) -> list[Section]:
    first = Section("Vessel surfaces compared", 1, [TEXT.format(**content), *content["notes"]])
    titles = Section(
        "Methods", items=[f"`{name}`: {METHODS[name].title}" for name in content["methods"]]
    )
    sections = [first, titles, Section("Data sets", table=input_table(content))]
    for given in content["inputs"]:
        sections += input_sections(given, pictures.get(given["name"], {}))
    return sections


def json_text(content: dict[str, Any]) -> str:
    """Five digits a number, and a list of numbers on one line."""
    text = json.dumps(rounded(content), indent=1)
    return re.sub(r"\[[-+\d.e,\s]+\]", lambda found: " ".join(found.group().split()), text) + "\n"


def write_text(content: dict[str, Any], sections: list[Section], folder: Path) -> None:
    (folder / "report.md").write_text(markdown(sections))
    (folder / "report.json").write_text(json_text(content))

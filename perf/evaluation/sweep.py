"""The user's constants, one at a time away from their defaults: what each does to the surface."""

from pathlib import Path
from typing import Any

import process

from .inputs import Input
from .measure import check, last_line
from .tables import Section, Table, number

CONSTANTS: dict[str, tuple[str, list[float | str]]] = {
    "rho": ("--rho", [0.3, 0.45, 0.6, 0.8, 1.0]),
    "k": ("--neighbours", [5, 10, 15, 20, 30]),
    "edge-min": ("--edge-min", [0.7, 0.9, 1.1, 1.3, 1.5]),
    "edge-max": ("--edge-max", [1.2, 1.4, 1.6, 2.0, 2.5]),
    "normals": ("--normals", ["covariance", "gradient"]),
}
DEFAULTS = {"rho": 0.6, "k": 10, "edge-min": 1.1, "edge-max": 1.6, "normals": "covariance"}


def one_run(
    program: Path, given: Input, words: list[str], folder: Path, timeout: float
) -> dict[str, Any]:
    surface = folder / f"{given.name}_sweep.ply"
    outcome = process.run(
        [
            program,
            "convert",
            given.volume,
            "-o",
            surface,
            "--label",
            "any",
            "--surface",
            "adaptive",
            "--quiet",
            *words,
        ],
        timeout=timeout,
    )
    if outcome.timed_out or outcome.code != 0:
        reason = "timed out" if outcome.timed_out else last_line(outcome.error)
        return {"status": "failed", "reason": reason}
    report = check(program, surface, "--against", given.volume, "--label", "any")
    found = {
        "status": "done",
        "passed": report["check"]["passed"],
        "wall": outcome.wall,
        "triangles": report["check"]["triangles"],
        "mean_voxels": report["distance"]["to"]["mean_voxels"],
        "largest_mm": max(report["distance"][w]["maximum_mm"] for w in ("to", "back")),
        "above_08": report["quality"]["edge_ratio_above_08"],
        "least_angle_5": report["quality"]["least_angle"]["percentile_5"],
        "curvature_spread": report["rms_curvature"]["percentile_95"]
        - report["rms_curvature"]["percentile_5"],
    }
    if given.exact:
        exact = check(
            program,
            surface,
            "--against",
            given.volume,
            "--label",
            "any",
            "--reference",
            given.exact,
        )["distance"]
        found["exact_voxels"] = exact["to"]["mean_voxels"]
    return found


def sweep(program: Path, given: Input, folder: Path, timeout: float) -> dict[str, Any]:
    """Every value of every constant on one input; the defaults are run once."""
    standard = one_run(program, given, [], folder, timeout)
    constants: dict[str, list[dict[str, Any]]] = {}
    for name, (option, values) in CONSTANTS.items():
        constants[name] = []
        for value in values:
            run = (
                standard
                if value == DEFAULTS[name]
                else one_run(program, given, [option, str(value)], folder, timeout)
            )
            constants[name].append({"value": value, **run})
    return {"input": given.name, "constants": constants}


def sweep_table(content: dict[str, Any]) -> Table:
    lines = []
    for name, runs in content["constants"].items():
        for run in runs:
            title = f"{name} {run['value']}" + (
                " (default)" if run["value"] == DEFAULTS[name] else ""
            )
            if run["status"] != "done":
                lines.append([title, f"failed: {run['reason']}", *[""] * 8])
                continue
            lines.append(
                [
                    title,
                    "passed" if run["passed"] else "failed",
                    f"{run['triangles']:,}",
                    number(run["mean_voxels"], 3),
                    number(run["largest_mm"], 3),
                    number(run.get("exact_voxels"), 3),
                    number(100 * run["above_08"], 1),
                    number(run["least_angle_5"], 1),
                    number(run["curvature_spread"], 2),
                    number(run["wall"], 1),
                ]
            )
    return Table(
        [
            "constant",
            "check",
            "triangles",
            "mean distance, voxels",
            "largest, mm",
            "mean to the exact surface, voxels",
            "edge ratio of 0.8 and above, %",
            "least angle, 5th percentile",
            "curvature spread, 1/mm",
            "wall clock, s",
        ],
        lines,
    )


def sweep_section(content: dict[str, Any], picture: str | None) -> Section:
    return Section(
        f"The user's constants, on {content['input']}",
        text=[
            "One constant at a time away from its default. The distance is that to "
            "marching cubes; the largest is of both ways."
        ],
        table=sweep_table(content),
        pictures=[(picture, "Triangles, mean distance and shape by constant")] if picture else [],
    )

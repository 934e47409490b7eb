#!/usr/bin/env python3
"""The figures of our surfaces: every phantom, random trees, every volume of a data folder.

Each input goes through `vasamesh convert` at 1, 2 and 4 threads and, where there is a device, on
OpenCL (the files must be the same bytes) and `vasamesh check`. Writes OUT.json and OUT.md; ends
with code 1 when a figure is outside its limit. Needs no package; with those of
perf/requirements.txt it knows the real vessels' radii, and so the number of triangles that they may
have.

    perf/table.py --data FOLDER [--surface adaptive|base]
"""

import argparse
import functools
import hashlib
import json
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any, Iterator

import process
import table_text
from table_figures import Row, outside

Case = dict[str, Any]

WAYS = (("--threads", "1"), ("--threads", "2"), ("--threads", "4"))  # of running a conversion
MEASURED = WAYS[1]
ON_OPENCL = ("--backend", "opencl")
VOLUME_ENDINGS = (".nii.gz", ".nii", ".mha", ".mhd", ".nrrd")


class Failed(Exception):
    """A run of the program that did not end with 0."""


def program_run(words: list[Any], codes: tuple[int, ...] = (0,)) -> process.Outcome:
    outcome = process.run_apart(words)
    if outcome.code not in codes:
        message = outcome.error.strip().splitlines() or ["no message"]
        raise Failed(f"{words[1]} ended with {outcome.code}: {message[-1]}")
    return outcome


def check(program: Path, surface: Path, *options: Any) -> dict[str, Any]:
    """`vasamesh check --json`; a surface that fails is a result too."""
    return json.loads(program_run([program, "check", surface, "--json", *options], (0, 4)).output)


def stem(path: Path) -> str | None:
    for ending in VOLUME_ENDINGS:
        if path.name.endswith(ending):
            return path.name[: -len(ending)]
    return None


def phantom_cases(cases_program: Path, trees: int) -> Iterator[Case]:
    """The inputs that vasamesh_cases lists."""
    for line in program_run([cases_program, str(trees)]).output.splitlines():
        label, kind, exact, accurate, arguments = line.split("\t")
        yield {
            "label": label,
            "kind": kind,
            "exact": exact == "1" and kind in ("small", "accuracy"),
            "accurate": accurate == "1",
            "arguments": arguments.split(),
        }


def data_cases(folder: Path) -> Iterator[Case]:
    """Every volume of the folder; a surface STEM.vtk beside it is a reference (in RAS)."""
    for path in sorted(folder.iterdir()):
        if stem(path):
            reference = folder / (stem(path) + ".vtk")
            yield {
                "label": stem(path),
                "kind": "data",
                "exact": False,
                "accurate": False,
                "volume": path,
                "reference": reference if reference.exists() else None,
            }


@functools.cache
def ways_of(program: Path) -> tuple[tuple[str, str], ...]:
    """With OpenCL where there is a device of it."""
    devices = program_run([program, "devices"]).output
    return (*WAYS, ON_OPENCL) if re.search(r"\bopencl\b", devices) else WAYS


def convert(
    program: Path, volume: Path, output: Path, kind: str, options: list[str]
) -> tuple[process.Outcome, dict[str, Any]]:
    """One conversion: the process and its report."""
    report = output.with_suffix(".json")
    words = [program, "convert", volume, "-o", output, "--report", report, "--surface", kind]
    outcome = program_run([*words, "--quiet", *options])
    return outcome, json.loads(report.read_text())


def convert_all(
    program: Path, volume: Path, folder: Path, kind: str, options: list[str]
) -> tuple[Path, Row]:
    """One conversion a way: the surface and the row's figures of the work."""
    digests, row = set(), {}
    for way in ways_of(program):
        surface = folder / f"{way[1]}.ply"
        outcome, content = convert(program, volume, surface, kind, [*way, *options])
        digests.add(hashlib.sha256(surface.read_bytes()).hexdigest())
        if way == MEASURED:
            row.update(
                wall=outcome.wall,
                cpu=outcome.cpu,
                peak=outcome.peak,
                stages={s["name"]: s["seconds"] for s in content["stages"]},
                spacing=content["geometry"]["spacing"],
                size=content["geometry"]["size"],
                object_voxels=content["input"]["object_voxels"],
                points=content["points"],
                relabel=content["relabel"],
                mesh=content["mesh"],
            )
    row["same_bytes"] = len(digests) == 1
    return folder / f"{MEASURED[1]}.ply", row


def median_radius(volume: Path) -> float | None:
    """Of inscribed balls, voxels; None without the packages for it."""
    try:
        from evaluation.branching import median_radius as measured
    except ImportError:
        return None
    return measured(volume)


def distances(report: dict[str, Any]) -> dict[str, Any]:
    """Both ways: mean in voxels, largest in mm."""
    ways = report["distance"]
    return {
        way: {
            "mean_voxels": ways[way]["mean_voxels"],
            "rms_voxels": ways[way]["rms_voxels"],
            "largest_mm": ways[way]["maximum_mm"],
        }
        for way in ("to", "back")
    }


def against_reference(
    program: Path, surface: Path, volume: Path, options: list[str], reference: Path
) -> dict[str, Any]:
    """Distance and relative volume error to a reference surface."""
    report = check(program, surface, "--against", volume, *options, "--reference", reference)
    wanted = check(program, reference)["quality"]["volume"]
    return {**distances(report), "volume_error": report["quality"]["volume"] / wanted - 1}


def make_volume(program: Path, case: Case, folder: Path) -> tuple[Path, Path | None]:
    """The case's volume, and its exact surface where there is one."""
    if "volume" in case:
        return case["volume"], None
    volume, exact = folder / "volume.nii.gz", folder / "exact.ply" if case["exact"] else None
    words = ["--surface", exact] if exact else []
    program_run([program, "phantom", *case["arguments"], "-o", volume, *words])
    return volume, exact


def to_reference(
    program: Path, case: Case, kind: str, folder: Path, options: list[str]
) -> dict[str, Any]:
    """The figures to a reference that lies beside a volume."""
    turned, in_ras = folder / "ras.ply", [*options, "--space", "ras"]
    convert(program, case["volume"], turned, kind, [*MEASURED, *in_ras])
    return against_reference(program, turned, case["volume"], in_ras, case["reference"])


def measure(program: Path, case: Case, kind: str, folder: Path) -> Row:
    """All figures of one input."""
    volume, exact = make_volume(program, case, folder)
    options = ["--label", "any"] if case["kind"] == "data" else []
    surface, row = convert_all(program, volume, folder, kind, options)
    report = check(program, surface, "--against", volume, *options)
    row.update(
        check=report["check"],
        distance=distances(report),
        quality=report["quality"],
        marching_cubes=report["distance"]["reference_triangles"],
    )
    if exact:
        row["exact"] = against_reference(program, surface, volume, options, exact)
    if case.get("reference"):
        row["exact"] = to_reference(program, case, kind, folder, options)
    if kind == "adaptive" and case["kind"] in ("large", "data"):
        base = folder / "b.ply"
        row["base_peak"] = convert(program, volume, base, "base", [*MEASURED, *options])[0].peak
    if case["kind"] == "data":
        row["median_radius"] = median_radius(volume)
    return row


def examine(program: Path, case: Case, kind: str) -> Row:
    """One row: figures, or why there are none."""
    row = {"label": case["label"], "kind": case["kind"], "accurate": case["accurate"]}
    folder = Path(tempfile.mkdtemp(prefix="vasamesh-perf-"))
    try:
        row.update(measure(program, case, kind, folder))
        row["outside"] = outside(kind, row)
    except Failed as failure:
        row["failed"] = str(failure).replace(str(folder) + "/", "")
        row["outside"] = [row["failed"]]
    finally:
        shutil.rmtree(folder)
    return row


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/release/vasamesh"))
    parser.add_argument("--surface", choices=("adaptive", "base"), default="adaptive")
    parser.add_argument(
        "--data",
        type=Path,
        default=os.environ.get("VASAMESH_TEST_DATA"),
        help="folder of volumes; VASAMESH_TEST_DATA by default",
    )
    parser.add_argument("--trees", type=int, default=100, help="random trees")
    parser.add_argument("--only", default="", help="a pattern: only inputs of such labels")
    parser.add_argument(
        "-o", "--output", type=Path, help="without an ending; perf/results/KIND_surface by default"
    )
    arguments = parser.parse_args()
    arguments.program = arguments.program.resolve()
    if arguments.output is None:
        arguments.output = Path(f"perf/results/{arguments.surface}_surface")
    return arguments


def chosen_cases(arguments: argparse.Namespace) -> list[Case]:
    cases = list(phantom_cases(arguments.program.parent / "vasamesh_cases", arguments.trees))
    if arguments.data:
        cases += data_cases(Path(arguments.data))
    return [case for case in cases if re.search(arguments.only, case["label"])]


def main() -> int:
    arguments = parse_arguments()
    rows = []
    for case in chosen_cases(arguments):
        rows.append(examine(arguments.program, case, arguments.surface))
        print(
            f"{case['label']}: {'; '.join(rows[-1]['outside']) or 'within all limits'}",
            file=sys.stderr,
            flush=True,
        )
    content = {
        "schema_version": 1,
        "surface": arguments.surface,
        "machine": process.machine(),
        "load": round(process.load(), 1),
        "version": program_run([arguments.program, "--version"]).output.strip(),
        "rows": rows,
    }
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    Path(f"{arguments.output}.json").write_text(table_text.compact_json(content))
    Path(f"{arguments.output}.md").write_text(table_text.markdown(content))
    return 1 if any(row["outside"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())

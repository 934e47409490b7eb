#!/usr/bin/env python3
"""The figures of the base surface: every phantom, random trees, every volume of a data folder.

Each input goes through `vasamesh convert` at 1, 2 and 4 threads (the files must be the same bytes)
and `vasamesh check`. Writes OUT.json and OUT.md; ends with code 1 when a figure is outside its
limit. Needs no package.

    perf/table.py --program build/release/vasamesh --data FOLDER -o perf/results/base_surface
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

import process
import table_text

THREADS = (1, 2, 4)
VOLUME_ENDINGS = (".nii.gz", ".nii", ".mha", ".mhd", ".nrrd")
DEFECTS = ("open_edges", "nonmanifold_edges", "misoriented_edges", "nonmanifold_vertices",
           "isolated_vertices", "degenerate_triangles", "nonfinite_vertices", "intersecting_pairs",
           "inverted_shells", "mismatched_pieces")

# Limits. Lengths in voxels, the geometric mean of the spacings, unless they are named mm.
MEAN_LIMIT_DATA, MEAN_LIMIT_PHANTOM = 0.17, 0.27
EXACT_MEAN_LIMIT, EXACT_VOLUME_LIMIT = 0.12, 0.02
MEMORY_LIMITS = {"cerebral": 1e9, "airways": 3e9}


class Failed(Exception):
    """A run of the program that did not end with 0."""


def largest_limit(spacing):
    """How far the surface may be from marching cubes, mm."""
    return max(min(spacing), 0.55 * max(spacing))


def voxel_length(spacing):
    return (spacing[0] * spacing[1] * spacing[2]) ** (1 / 3)


def program_run(words, codes=(0,)):
    outcome = process.run(words)
    if outcome.code not in codes:
        message = outcome.error.strip().splitlines() or ["no message"]
        raise Failed(f"{words[1]} ended with {outcome.code}: {message[-1]}")
    return outcome


def check(program, surface, *options):
    """`vasamesh check --json`; a surface that fails is a result too."""
    return json.loads(program_run([program, "check", surface, "--json", *options], (0, 4)).output)


def stem(path):
    for ending in VOLUME_ENDINGS:
        if path.name.endswith(ending):
            return path.name[:-len(ending)]
    return None


def phantom_cases(cases_program, trees):
    """The inputs that vasamesh_cases lists."""
    for line in program_run([cases_program, str(trees)]).output.splitlines():
        label, kind, exact, accurate, arguments = line.split("\t")
        yield {"label": label, "kind": kind, "exact": exact == "1" and kind in ("small", "accuracy"),
               "accurate": accurate == "1", "arguments": arguments.split()}


def data_cases(folder):
    """Every volume of the folder; a surface STEM.vtk beside it is a reference (in RAS)."""
    for path in sorted(folder.iterdir()):
        if stem(path):
            reference = folder / (stem(path) + ".vtk")
            yield {"label": stem(path), "kind": "data", "exact": False, "accurate": False,
                   "volume": path, "reference": reference if reference.exists() else None}


def convert_all(program, volume, folder, options):
    """One conversion a number of threads: the surface and the row's figures of the work."""
    digests, row = set(), {}
    for threads in THREADS:
        surface, report = folder / f"{threads}.ply", folder / f"{threads}.json"
        outcome = program_run([program, "convert", volume, "-o", surface, "--report", report,
                               "--surface", "base", "--threads", threads, "--quiet", *options])
        digests.add(hashlib.sha256(surface.read_bytes()).hexdigest())
        if threads == 2:
            content = json.loads(report.read_text())
            row.update(wall=outcome.wall, cpu=outcome.cpu, peak=outcome.peak,
                       stages={s["name"]: s["seconds"] for s in content["stages"]},
                       spacing=content["geometry"]["spacing"], size=content["geometry"]["size"],
                       object_voxels=content["input"]["object_voxels"], points=content["points"],
                       relabel=content["relabel"])
    row["same_bytes"] = len(digests) == 1
    return folder / "2.ply", row


def distances(report):
    """Both ways: mean in voxels, largest in mm."""
    ways = report["distance"]
    return {way: {"mean_voxels": ways[way]["mean_voxels"], "rms_voxels": ways[way]["rms_voxels"],
                  "largest_mm": ways[way]["maximum_mm"]} for way in ("to", "back")}


def against_reference(program, surface, volume, options, reference):
    """Distance and relative volume error to a reference surface."""
    report = check(program, surface, "--against", volume, *options, "--reference", reference)
    wanted = check(program, reference)["quality"]["volume"]
    return {**distances(report), "volume_error": report["quality"]["volume"] / wanted - 1}


def measure(program, case, folder):
    """All figures of one input."""
    volume, options, reference = case.get("volume"), [], case.get("reference")
    if volume is None:
        volume = folder / "volume.nii.gz"
        exact = folder / "exact.ply"
        words = ["--surface", exact] if case["exact"] else []
        program_run([program, "phantom", *case["arguments"], "-o", volume, *words])
    else:
        options = ["--label", "any"]
    surface, row = convert_all(program, volume, folder, options)
    report = check(program, surface, "--against", volume, *options)
    row.update(check=report["check"], distance=distances(report),
               quality={k: report["quality"][k]
                        for k in ("edge_ratio", "least_angle", "size_ratio", "volume")})
    if case["exact"]:
        row["exact"] = against_reference(program, surface, volume, options, exact)
    if reference:
        turned = folder / "ras.ply"
        program_run([program, "convert", volume, "-o", turned, "--surface", "base",
                     "--space", "ras", "--quiet", *options])
        row["exact"] = against_reference(program, turned, volume, [*options, "--space", "ras"],
                                         reference)
    return row


def outside(case, row):
    """The figures outside their limits, in words."""
    found = [f"{row['check'][name]} {name}" for name in DEFECTS if row["check"][name]]
    if row["check"]["topology"] != row["check"]["wanted"]:
        found.append("topology")
    if not row["check"]["passed"] and not found:
        found.append(row["check"]["reason"])
    if not row["same_bytes"]:
        found.append("bytes differ by threads")
    mean_limit = MEAN_LIMIT_DATA if case["kind"] == "data" else MEAN_LIMIT_PHANTOM
    for way, d in row["distance"].items():
        if d["mean_voxels"] > mean_limit:
            found.append(f"mean {way} {d['mean_voxels']:.3f} above {mean_limit} voxel")
        if d["largest_mm"] >= row["limit_mm"]:
            found.append(f"largest {way} {d['largest_mm']:.3f} not under {row['limit_mm']:.3f} mm")
    if case["accurate"]:
        exact = row["exact"]
        for way in ("to", "back"):
            if exact[way]["mean_voxels"] > EXACT_MEAN_LIMIT:
                found.append(f"mean {way} the exact surface {exact[way]['mean_voxels']:.3f} above "
                             f"{EXACT_MEAN_LIMIT} voxel")
        if abs(exact["volume_error"]) > EXACT_VOLUME_LIMIT:
            found.append(f"volume {100 * exact['volume_error']:+.2f} % off")
    if row["peak"] > MEMORY_LIMITS.get(case["label"], float("inf")):
        found.append(f"peak memory {row['peak'] / 1e9:.2f} GB")
    return found


def examine(program, case):
    """One row: figures, or why there are none."""
    row = {"label": case["label"], "kind": case["kind"], "accurate": case["accurate"]}
    folder = Path(tempfile.mkdtemp(prefix="vasamesh-perf-"))
    try:
        row.update(measure(program, case, folder))
        row["voxel_mm"] = voxel_length(row["spacing"])
        row["limit_mm"] = largest_limit(row["spacing"])
        row["outside"] = outside(case, row)
    except Failed as failure:
        row["failed"] = str(failure).replace(str(folder) + "/", "")
        row["outside"] = [row["failed"]]
    finally:
        shutil.rmtree(folder)
    return row


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/release/vasamesh"))
    parser.add_argument("--data", type=Path, default=os.environ.get("VASAMESH_TEST_DATA"),
                        help="folder of volumes; VASAMESH_TEST_DATA by default")
    parser.add_argument("--trees", type=int, default=100, help="random trees")
    parser.add_argument("--only", default="", help="a pattern: only inputs of such labels")
    parser.add_argument("-o", "--output", type=Path, default=Path("perf/results/base_surface"))
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    program = arguments.program.resolve()
    cases = list(phantom_cases(program.parent / "vasamesh_cases", arguments.trees))
    if arguments.data:
        cases += data_cases(Path(arguments.data))
    rows = []
    for case in cases:
        if not re.search(arguments.only, case["label"]):
            continue
        rows.append(examine(program, case))
        print(f"{case['label']}: {'; '.join(rows[-1]['outside']) or 'within all limits'}",
              file=sys.stderr, flush=True)
    content = {"schema_version": 1, "machine": process.machine(), "load": round(process.load(), 1),
               "version": program_run([program, "--version"]).output.strip(), "rows": rows}
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    Path(f"{arguments.output}.json").write_text(table_text.compact_json(content))
    Path(f"{arguments.output}.md").write_text(table_text.markdown(content))
    return 1 if any(row["outside"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())

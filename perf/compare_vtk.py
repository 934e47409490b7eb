#!/usr/bin/env python3
"""Whole processes side by side: `vasamesh convert` with two threads against vasamesh_vtk_baseline.

Both turn the same .nii.gz into a .ply, in turns (A B A B ...), after one untimed run each. Writes
medians and ratios to OUT.json and OUT.md. Needs no package.

    perf/compare_vtk.py --program build/release/vasamesh -o perf/results/compare_vtk
"""

import argparse
import json
import statistics
import sys
import tempfile
from pathlib import Path

import process

AIM = 4  # of the ratio of wall times
FIGURES = (("wall", "wall clock, s", 1), ("cpu", "processor, s", 1),
           ("peak", "peak memory, MB", 1e-6))

TEXT = """\
# A whole conversion beside VTK's

Written by `perf/compare_vtk.py` on a {machine}: {input}, from .nii.gz to .ply, {repeats} runs each
in turns; medians, least and largest in brackets. {load} processes wanted a core on average during
the runs, so that wall-clock times are those of a shared machine and processor time (user and
system) is the steadier figure.

The baseline is FlyingEdges3D, WindowedSinc (20 iterations, pass band 0.1) and QuadricDecimation (by
half). It proves nothing: its surface is neither checked nor of the segmentation's topology.

| | vasamesh, 2 threads | VTK baseline | ratio |
|---|---|---|---|
{rows}
The aim is a ratio of at most {aim} in wall clock.

## Where the time goes

Seconds of wall clock, medians.

| vasamesh | | VTK baseline | |
|---|---|---|---|
{stages}"""


def timed(words):
    outcome = process.run(words)
    if outcome.code != 0:
        sys.exit(f"{Path(words[0]).name}: {outcome.error.strip() or outcome.code}")
    return outcome


def our_run(program, volume, folder):
    report = folder / "ours.json"
    outcome = timed([program, "convert", volume, "-o", folder / "ours.ply", "--threads", "2",
                     "--quiet", "--report", report])
    content = json.loads(report.read_text())
    steps = {stage["name"]: stage["seconds"] for stage in content["stages"]}
    return outcome, steps, content["check"]["triangles"]


def their_run(program, volume, folder):
    outcome = timed([program, volume, folder / "theirs.ply"])
    steps = json.loads(outcome.output)
    triangles = steps.pop("triangles")
    steps.pop("triangles_extracted")
    return outcome, steps, triangles


def summary(runs):
    """Figures and medians of (outcome, steps, triangles)."""
    found = {name: [getattr(outcome, name) for outcome, _, _ in runs] for name, _, _ in FIGURES}
    found["steps"] = {name: statistics.median(steps[name] for _, steps, _ in runs)
                      for name in runs[0][1]}
    found["triangles"] = runs[0][2]
    return found


def measure(program, volume, folder, repeats):
    baseline = program.parent / "vasamesh_vtk_baseline"
    ours, theirs, loads = [], [], []
    for repeat in range(repeats + 1):
        pair = our_run(program, volume, folder), their_run(baseline, volume, folder)
        loads.append(process.load())
        if repeat > 0:
            ours.append(pair[0])
            theirs.append(pair[1])
    return {"machine": process.machine(), "load": round(statistics.median(loads), 1),
            "repeats": repeats, "vasamesh": summary(ours), "vtk": summary(theirs)}


def figure_rows(content):
    lines = ""
    for name, title, scale in FIGURES:
        values = [[scale * v for v in content[side][name]] for side in ("vasamesh", "vtk")]
        digits = 0 if name == "peak" else 2
        cells = [f"{statistics.median(v):.{digits}f} ({min(v):.{digits}f} to {max(v):.{digits}f})"
                 for v in values]
        ratio = statistics.median(values[0]) / statistics.median(values[1])
        lines += f"| {title} | {cells[0]} | {cells[1]} | {ratio:.2f} |\n"
    counts = [content[side]["triangles"] for side in ("vasamesh", "vtk")]
    return lines + f"| triangles | {counts[0]:,} | {counts[1]:,} | {counts[0] / counts[1]:.1f} |\n"


def stage_rows(content):
    columns = [list(content[side]["steps"].items()) for side in ("vasamesh", "vtk")]
    lines = ""
    for i in range(max(map(len, columns))):
        cells = [f"{c[i][0]} | {c[i][1]:.2f}" if i < len(c) else " | " for c in columns]
        lines += f"| {cells[0]} | {cells[1]} |\n"
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/release/vasamesh"))
    parser.add_argument("--phantom", default="cerebral")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("-o", "--output", type=Path, default=Path("perf/results/compare_vtk"))
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    with tempfile.TemporaryDirectory(prefix="vasamesh-perf-") as name:
        volume = Path(name) / "volume.nii.gz"
        timed([program, "phantom", arguments.phantom, "-o", volume])
        content = measure(program, volume, Path(name), arguments.repeats)
    content["input"] = f"the phantom `{arguments.phantom}`"
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    Path(f"{arguments.output}.json").write_text(json.dumps(content, indent=1) + "\n")
    text = TEXT.format(**content, rows=figure_rows(content), stages=stage_rows(content), aim=AIM)
    Path(f"{arguments.output}.md").write_text(text)


if __name__ == "__main__":
    main()

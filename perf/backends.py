#!/usr/bin/env python3
"""Backends compared: `vasamesh bench` on the large phantoms and on trees of growing size.

Writes OUT.md (tables), OUT.json (what bench printed) and OUT.png (cost against foreground voxels
and against volume; needs matplotlib, and is left out with a word where that is missing).

    perf/backends.py --program build/release/vasamesh -o perf/results/backends
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import process

SIZES = (64, 96, 128, 192, 256, 384)  # voxels along each axis, of trees
STAGED = ("cerebral", "y_branch")  # phantoms of which every stage is shown

TEXT = """\
# Backends compared

Written by `perf/backends.py` on a {machine}; {load:.0f} processes wanted a core on average when it
ended. Medians of {repeat} conversions after one that warms up, without reading and writing. MB and
M operations are what a stage must move and do at least (`host/measure/work.h`); their shares are of
what the backend reaches in a triad and in multiplications and additions. "x" is the speed-up over
one oneTBB thread; "agrees" compares what each stage has come to with that of the first run: counts,
residuals, and the surface byte by byte.

{speeds}
{stages}
## Growing inputs

Random trees in volumes of growing size, in seconds. The plot is [backends.png](backends.png); its
crosses are the phantoms above.

{growth}"""


def run(words):
    outcome = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if outcome.returncode != 0:
        sys.exit(f"{Path(words[0]).name}: {outcome.stderr.strip()}")
    return outcome.stdout


def make_inputs(program, folder):
    """{label: path} of the phantoms."""
    inputs = {name: folder / f"{name}.nii.gz" for name in STAGED}
    for name, path in inputs.items():
        run([program, "phantom", name, "-o", path])
    for side in SIZES:
        path = inputs[f"tree {side}"] = folder / f"tree_{side}.nii.gz"
        run([program, "phantom", "tree", "--seed", 3, "--size", side, side, side, "-o", path])
    return inputs


def measure(program, inputs, repeat, options):
    found = []
    for label, path in inputs.items():
        words = [program, "bench", path, "--repeat", repeat, "--json", *options]
        content = json.loads(run(words))[0]
        content["input"] = label
        found.append(content)
    return found


def share(part, whole):
    return f"{100 * part / whole:.1f}" if part and whole else "-"


def stage_row(stage, run_, one_thread):
    seconds = max(stage["seconds"], 1e-9)
    ratio = f"{one_thread[stage['name']] / seconds:.2f}" if stage["name"] in one_thread else "-"
    return (f"| {stage['name']} | {stage['backend']} | {1e3 * seconds:.1f} | "
            f"{share(seconds, run_['seconds'])} | {stage['bytes'] * 1e-6:.0f} | "
            f"{share(stage['bytes'] / seconds, run_['bandwidth'])} | "
            f"{stage['operations'] * 1e-6:.0f} | "
            f"{share(stage['operations'] / seconds, run_['arithmetic'])} | {ratio} | "
            f"{stage['launches']} | {stage['bytes_copied'] * 1e-6:.1f} | "
            f"{'yes' if stage['agrees'] else 'NO'} |\n")


def stage_tables(content):
    text = f"## {content['input']}\n\n"
    text += (f"{content['voxels']:,} voxels, {content['object_voxels']:,} in the object, "
             f"{content['points']:,} points, {content['triangles']:,} triangles.\n")
    one = next((r for r in content["runs"] if r["name"] == "tbb 1"), {"stages": []})
    one_thread = {stage["name"]: stage["seconds"] for stage in one["stages"]}
    for run_ in content["runs"]:
        text += (f"\n### {content['input']}, {run_['name']}\n\n{1e3 * run_['seconds']:.0f} ms; buffers of "
                 f"{run_['bytes_peak'] * 1e-6:.0f} MB at most; cancelled within "
                 f"{1e3 * run_['longest_silence']:.0f} ms.\n\n| stage | on | ms | % | MB | "
                 f"% of bandwidth | M operations | % of peak | x | launches | MB copied | agrees |\n"
                 f"|---|---|---|---|---|---|---|---|---|---|---|---|\n")
        text += "".join(stage_row(stage, run_, one_thread) for stage in run_["stages"])
    return text + "\n"


def speed_table(content):
    text = "| backend | device | GB/s | G operations/s |\n|---|---|---|---|\n"
    for run_ in content["runs"]:
        text += (f"| {run_['name']} | {run_['device']} | {run_['bandwidth'] * 1e-9:.1f} | "
                 f"{run_['arithmetic'] * 1e-9:.0f} |\n")
    return text


def is_tree(content):
    return content["input"].startswith("tree")


def growth_table(found):
    trees = [content for content in found if is_tree(content)]
    names = [run_["name"] for run_ in trees[0]["runs"]]
    text = "| voxels | in the object | triangles | " + " | ".join(names) + " |\n"
    text += "|---" * (3 + len(names)) + "|\n"
    for content in trees:
        seconds = " | ".join(f"{run_['seconds']:.2f}" for run_ in content["runs"])
        text += (f"| {content['voxels']:,} | {content['object_voxels']:,} | "
                 f"{content['triangles']:,} | {seconds} |\n")
    return text


def plot(found, path):
    try:
        import matplotlib
    except ImportError:
        print("no matplotlib: no plot", file=sys.stderr)
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(10, 4), sharey=True)
    for axis, key, title in zip(axes, ("object_voxels", "voxels"),
                                ("foreground voxels", "voxels of the volume")):
        for i, run_ in enumerate(found[0]["runs"]):
            points = sorted((content[key], content["runs"][i]["seconds"], is_tree(content))
                            for content in found)
            line = axis.loglog(*zip(*((x, y) for x, y, tree in points if tree)), marker="o",
                               label=f"{run_['name']}, trees")[0]
            axis.loglog(*zip(*((x, y) for x, y, tree in points if not tree)), marker="x",
                        linestyle="none", color=line.get_color())
        axis.set_xlabel(title)
        axis.grid(True, which="both", alpha=0.3)
    axes[0].set_ylabel("seconds, without reading and writing")
    axes[0].legend()
    figure.tight_layout()
    figure.savefig(path, dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/release/vasamesh"))
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--bench", default="", help="more options of vasamesh bench")
    parser.add_argument("-o", "--output", type=Path, default=Path("perf/results/backends"))
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    with tempfile.TemporaryDirectory(prefix="vasamesh-perf-") as name:
        inputs = make_inputs(program, Path(name))
        found = measure(program, inputs, arguments.repeat, arguments.bench.split())
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    Path(f"{arguments.output}.json").write_text(json.dumps(found, indent=1) + "\n")
    stages = "".join(stage_tables(content) for content in found if content["input"] in STAGED)
    Path(f"{arguments.output}.md").write_text(TEXT.format(
        machine=process.machine(), load=process.load(), repeat=arguments.repeat,
        speeds=speed_table(found[0]), stages=stages, growth=growth_table(found)))
    plot(found, f"{arguments.output}.png")


if __name__ == "__main__":
    main()

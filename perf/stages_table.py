#!/usr/bin/env python3
"""The output of vasamesh_bench_stages as a Markdown table, each stage beside its floor.

    build/release/vasamesh_bench_stages --benchmark_out=stages.json
    perf/stages_table.py stages.json -o perf/results/stages.md
"""

import argparse
import json
from pathlib import Path

import process

TEXT = """\
# Stages and their floors

Written by `perf/stages_table.py` from `vasamesh_bench_stages` on a {machine}: the phantom
`cerebral`, two threads, load {load:.0f}. Processor time is the sum over threads; half of it is what a
quiet machine's clock would show if the work were spread evenly. The floor is the larger of bytes
over bandwidth and operations over arithmetic, as processor time too: each array that the stage
reads or makes moved once, and the float32 operations of its formulas without the search for their
operands. Measured with two threads: {bandwidth:.1f} GB/s (triad), {arithmetic:.0f} G operations/s
(float32 multiply and add, no fma).

| stage | wall, 1 thread, ms | processor, 1 thread, ms | wall, 2 threads, ms | processor, 2 threads, ms | floor: MB | floor: M operations | floor, ms | processor over floor |
|---|---|---|---|---|---|---|---|---|
"""


def by_stage(benchmarks):
    """{stage: {threads: benchmark}} in order."""
    stages = {}
    for benchmark in benchmarks:
        name, threads = benchmark["name"].split("/")[:2]
        stages.setdefault(name, {})[int(threads.split(":")[1])] = benchmark
    return stages


def row(name, one, two):
    floor = 2 * two["floor_ms"]  # of both threads
    return (f"| {name} | {one['real_time']:.1f} | {one['cpu_time']:.1f} | {two['real_time']:.1f} | "
            f"{two['cpu_time']:.1f} | {two['floor_MB']:.0f} | {two['floor_Mop']:.0f} | {floor:.1f} "
            f"| {two['cpu_time'] / floor:.0f} |\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("input", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("perf/results/stages.md"))
    arguments = parser.parse_args()
    content = json.loads(arguments.input.read_text())
    context, stages = content["context"], by_stage(content["benchmarks"])
    text = TEXT.format(machine=process.machine(), load=context["load_avg"][0],
                       bandwidth=float(context["bandwidth_GBps_2_threads"]),
                       arithmetic=float(context["arithmetic_Gops_2_threads"]))
    text += "".join(row(name, runs[1], runs[2]) for name, runs in stages.items())
    total = {n: sum(runs[n]["cpu_time"] for runs in stages.values()) for n in (1, 2)}
    floor = sum(2 * runs[2]["floor_ms"] for runs in stages.values())
    text += (f"| all | | {total[1]:.0f} | | {total[2]:.0f} | | | {floor:.0f} | "
             f"{total[2] / floor:.1f} |\n")
    arguments.output.write_text(text)


if __name__ == "__main__":
    main()

"""One method on one input: run, checked, measured."""

import json
from pathlib import Path
from typing import Any

import process

from .inputs import Input
from .methods import METHODS, Job, Method

Row = dict[str, Any]


def last_line(text: str) -> str:
    lines = text.strip().splitlines()
    return lines[-1].strip() if lines else "no message"


def failed(method: str, status: str, reason: str) -> Row:
    return {"method": method, "status": status, "reason": reason}


def check(program: Path, surface: Path, *options: str | Path) -> dict[str, Any]:
    """`vasamesh check --json`; a surface that fails is a result too.
    :raises ValueError: there is no report; the message says why."""
    outcome = process.run([program, "check", surface, "--json", *options])
    if outcome.code not in (0, 4):
        raise ValueError(last_line(outcome.error))
    return json.loads(outcome.output)


def run_steps(name: str, method: Method, job: Job, timeout: float) -> Row:
    """The work itself: time and memory of the processes."""
    row: Row = {"method": name, "status": "done", "stages": {}, "wall": 0.0, "cpu": 0.0, "peak": 0}
    for step, command in method.steps(job).items():
        left = timeout - row["wall"]
        outcome = process.run_apart(command, max(left, 0.1), Path(__file__).parents[1])
        row["wall"] += outcome.wall
        row["cpu"] += outcome.cpu
        row["peak"] = max(row["peak"], outcome.peak)
        row["stages"][step] = outcome.wall
        if outcome.timed_out:
            return failed(name, "timed out", f"not done after {timeout:g} s")
        if outcome.code != 0:
            return failed(name, "failed", last_line(outcome.error))
    if not job.surface.exists():
        return failed(name, "failed", "no surface was written")
    return row


def our_stages(report: Path, row: Row) -> None:
    """Times and held memory by stage, where the program reports them."""
    content = json.loads(report.read_text())
    row["stages"] = {s["name"]: s["seconds"] for s in content["stages"]}
    row["held"] = {s["name"]: s["bytes_held"] for s in content["stages"]}


def measure(name: str, given: Input, build: Path, folder: Path, timeout: float) -> Row:
    """All figures of one method on one input; a row that says why where there are none. The surface
    and its map stay in the folder."""
    method = METHODS[name]
    missing = method.missing(build)
    if missing:
        return failed(name, "missing", missing)
    stem = f"{given.name}_{name}"
    job = Job(build, given.volume, folder / f"{stem}.ply", folder / f"{stem}.json", folder)
    row = run_steps(name, method, job, timeout)
    if row["status"] != "done":
        return row
    if job.report.exists():
        our_stages(job.report, row)
    program = build / "vasamesh"
    against = ["--against", given.volume, "--label", "any"]
    try:
        report = check(program, job.surface, *against, "--map", folder / f"{stem}.vtp")
        row.update({key: report[key] for key in ("check", "quality", "rms_curvature", "distance")})
        if given.exact:
            row["exact"] = check(program, job.surface, *against, "--reference", given.exact)[
                "distance"
            ]
    except ValueError as error:
        return failed(name, "failed", str(error))
    return row

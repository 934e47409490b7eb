"""The command line of perf/compare."""

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

import process

from .inputs import BadInput, Input, open_input
from .methods import METHODS
from .report import draw_input, evaluate, sections_of, write_text
from .sweep import sweep, sweep_section
from .tables import Section

BAD_INPUT, USAGE = 3, 2
EPILOG = (
    """inputs: volumes (every voxel but 0 is the vessel) and names of phantoms. Methods: """
    + ", ".join(METHODS)
)


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="perf/compare", description="Methods compared on vessels", epilog=EPILOG
    )
    parser.add_argument("inputs", nargs="+", metavar="IN", help="a volume, or a phantom's name")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--methods", default=",".join(METHODS), help="separated by commas")
    parser.add_argument(
        "--build", type=Path, default=Path("build/release"), help="folder of programs"
    )
    parser.add_argument("--timeout", type=float, default=600, help="seconds a method may take")
    parser.add_argument(
        "--sweep", metavar="IN", help="also vary the user's constants on this input"
    )
    parser.add_argument(
        "--page-triangles",
        type=int,
        default=100_000,
        help="most triangles of a surface that the page shows whole",
    )
    parser.add_argument("--tables-only", action="store_true", help="no pictures and no page")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the surfaces there")
    options = parser.parse_args(arguments)
    options.methods = list(dict.fromkeys(name.strip() for name in options.methods.split(",")))
    unknown = [name for name in options.methods if name not in METHODS]
    if unknown:
        parser.error(f"--methods {','.join(unknown)}: there are {', '.join(METHODS)}")
    if not 0 < options.timeout < float("inf"):
        parser.error(f"--timeout {options.timeout:g}: give seconds above 0")
    if options.page_triangles < 0:
        parser.error(f"--page-triangles {options.page_triangles}: give 0 or more")
    options.build = options.build.resolve()
    if not (options.build / "vasamesh").exists():
        parser.error(f"--build {options.build}: no vasamesh there; build it or name its folder")
    for folder in filter(None, (options.output, options.keep)):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            parser.error(f"{folder}: {error.strerror}; name a folder that can be written")
    return options


def draw_all(
    content: dict[str, Any], options: argparse.Namespace, scratch: Path
) -> tuple[dict[str, dict[str, str]], dict[str, Any]]:
    """Pictures and scenes of each input; what is missing is said in the report's notes."""
    pictures, scenes = {}, {}
    try:
        for found in content["inputs"]:
            pictures[found["name"]], scene = draw_input(
                found, options.output, scratch, options.page_triangles
            )
            if scene:
                scenes[found["name"]] = scene
    except ImportError as error:
        content["notes"].append(
            f"No Python package {error.name} here: no pictures; see " "perf/requirements.txt."
        )
    return pictures, scenes


def add_sweep(
    content: dict[str, Any], options: argparse.Namespace, given: Input, scratch: Path
) -> Section:
    print(f"{given.name}: the user's constants", flush=True)
    content["sweep"] = sweep(options.build / "vasamesh", given, scratch, options.timeout)
    try:
        from .pictures import draw_sweep
    except ImportError:
        return sweep_section(content["sweep"], None)
    picture = None if options.tables_only else "sweep.png"
    if picture:
        draw_sweep(content["sweep"], options.output / picture)
    return sweep_section(content["sweep"], picture)


def write_page(
    options: argparse.Namespace, sections: list[Section], scenes: dict[str, Any]
) -> None:
    try:
        from .page import NoThree, write_page as write
    except ImportError as error:
        print(f"perf/compare: no page: no Python package {error.name} here", file=sys.stderr)
        return
    try:
        write(options.output / "report.html", sections, scenes)
    except NoThree as error:
        print(f"perf/compare: no page: {error}", file=sys.stderr)


def compare(options: argparse.Namespace, scratch: Path) -> None:
    program = options.build / "vasamesh"
    names: set[str] = set()
    inputs = {text: open_input(text, program, scratch, names) for text in options.inputs}
    swept = None
    if options.sweep:
        swept = inputs.get(options.sweep) or open_input(options.sweep, program, scratch, names)
    content: dict[str, Any] = {
        "machine": process.machine(),
        "methods": options.methods,
        "notes": [],
    }
    content["inputs"] = [
        evaluate(given, options.methods, options.build, scratch, options.timeout)
        for given in inputs.values()
    ]
    content["version"] = f"vasamesh {content['inputs'][0]['version']}"
    for found in content["inputs"]:
        content["notes"] += [note for note in found["notes"] if note not in content["notes"]]
    pictures, scenes = ({}, {}) if options.tables_only else draw_all(content, options, scratch)
    extra = [add_sweep(content, options, swept, scratch)] if swept else []
    content["load"] = process.load()
    sections = sections_of(content, pictures) + extra
    write_text(content, sections, options.output)
    if not options.tables_only:
        write_page(options, sections, scenes)


def main(arguments: list[str] | None = None) -> int:
    options = parse(sys.argv[1:] if arguments is None else arguments)
    options.output = options.output.resolve()
    try:
        if options.keep:
            compare(options, options.keep.resolve())
        else:
            with tempfile.TemporaryDirectory(prefix="vasamesh-compare-") as scratch:
                compare(options, Path(scratch))
    except (BadInput, ValueError) as error:
        print(f"perf/compare: {error}", file=sys.stderr)
        return BAD_INPUT
    return 0

"""The inputs: volume files, and phantoms by name."""

import importlib.util
import re
from dataclasses import dataclass
from pathlib import Path

import process

ENDINGS = (".nii.gz", ".nii", ".mha", ".mhd", ".seg.nrrd", ".nrrd")


class BadInput(Exception):
    """An input that cannot be had; the message says which and why."""


@dataclass(frozen=True)
class Input:
    name: str
    volume: Path
    exact: Path | None  # surface of the shape itself, mm, LPS


def phantom_names(program: Path) -> set[str]:
    return set(
        re.findall(
            r"^\s+([a-z_]+)\s{2,}", process.run([program, "phantom", "--help"]).output, re.MULTILINE
        )
    )


def stem(path: Path) -> str:
    for ending in ENDINGS:
        if path.name.endswith(ending):
            return path.name[: -len(ending)]
    return path.name


def free_name(name: str, taken: set[str]) -> str:
    """The name, with "-2", "-3" behind it where others have it: files and headings go by names."""
    free, count = name, 1
    while free in taken:
        count += 1
        free = f"{name}-{count}"
    taken.add(free)
    return free


def reference_beside(volume: Path, copy: Path) -> Path | None:
    """The surface STEM.vtk (mm, RAS) that lies beside a volume STEM.ENDING and is what it was drawn
    from, copied to LPS; None where there is none, or no Python package vtk."""
    given = volume.parent / f"{stem(volume)}.vtk"
    if not given.exists() or importlib.util.find_spec("vtkmodules") is None:
        return None
    from .surfaces import to_lps  # optional package

    to_lps(given, copy)
    return copy


def open_input(text: str, program: Path, folder: Path, taken: set[str]) -> Input:
    """A file or DICOM folder as it is; a phantom's name: made in the folder. Its name is one that
    is not taken yet.
    :raises BadInput: it is neither, or the phantom cannot be made."""
    if Path(text).exists():
        path = Path(text).resolve()
        name = free_name(stem(path), taken)
        return Input(name, path, reference_beside(path, folder / f"{name}_exact.ply"))
    if text not in phantom_names(program):
        raise BadInput(
            f"{text}: no such file, and no phantom of that name; see `vasamesh phantom " "--help`"
        )
    name = free_name(text, taken)
    volume, exact = folder / f"{name}.nii.gz", folder / f"{name}_exact.ply"
    outcome = process.run([program, "phantom", text, "-o", volume, "--surface", exact])
    if outcome.code != 0:
        outcome = process.run([program, "phantom", text, "-o", volume])
    if outcome.code != 0:
        raise BadInput(outcome.error.strip())
    return Input(name, volume, exact if exact.exists() else None)

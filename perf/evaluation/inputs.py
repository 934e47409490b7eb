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


def reference_beside(volume: Path, folder: Path) -> Path | None:
    """The surface STEM.vtk (mm, RAS) that lies beside a volume STEM.ENDING and is what it was drawn
    from, copied to LPS; None where there is none, or no Python package vtk."""
    given = volume.parent / f"{stem(volume)}.vtk"
    if not given.exists() or importlib.util.find_spec("vtkmodules") is None:
        return None
    from .surfaces import to_lps  # optional package

    copy = folder / f"{stem(volume)}_exact.ply"
    to_lps(given, copy)
    return copy


def open_input(text: str, program: Path, folder: Path) -> Input:
    """A file or DICOM folder as it is; a phantom's name: made in the folder.
    :raises BadInput: it is neither, or the phantom cannot be made."""
    if Path(text).exists():
        path = Path(text).resolve()
        return Input(stem(path), path, reference_beside(path, folder))
    if text not in phantom_names(program):
        raise BadInput(
            f"{text}: no such file, and no phantom of that name; see `vasamesh phantom " "--help`"
        )
    volume, exact = folder / f"{text}.nii.gz", folder / f"{text}_exact.ply"
    outcome = process.run([program, "phantom", text, "-o", volume, "--surface", exact])
    if outcome.code != 0:
        outcome = process.run([program, "phantom", text, "-o", volume])
    if outcome.code != 0:
        raise BadInput(outcome.error.strip())
    return Input(text, volume, exact if exact.exists() else None)

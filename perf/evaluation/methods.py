"""The methods: what each runs, and what it needs."""

import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

Command = list[str | Path]
PERF = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Job:
    """One conversion: programs, the input, and files that a method may write."""

    build: Path
    volume: Path
    surface: Path
    report: Path  # ours: the conversion's report
    scratch: Path


@dataclass(frozen=True)
class Method:
    title: str
    steps: Callable[[Job], dict[str, Command]]  # by name, in order
    programs: tuple[str, ...] = ()  # of the build folder
    packages: tuple[tuple[str, str], ...] = ()  # (module, what to install)

    def missing(self, build: Path) -> str:
        """What is not here, in words; empty when the method can run."""
        for program in self.programs:
            if not (build / program).exists():
                return f"no {program}: build with -DVASAMESH_BASELINES=ON"
        for module, package in self.packages:
            if importlib.util.find_spec(module) is None:
                return f"no Python package {package}: pip install {package}"
        return ""


def ours(kind: str, *options: str) -> Callable[[Job], dict[str, Command]]:
    def steps(job: Job) -> dict[str, Command]:
        return {
            "convert": [
                job.build / "vasamesh",
                "convert",
                job.volume,
                "-o",
                job.surface,
                "--label",
                "any",
                "--surface",
                kind,
                "--report",
                job.report,
                "--quiet",
                *options,
            ]
        }

    return steps


def baseline(name: str, *options: str) -> Callable[[Job], dict[str, Command]]:
    def steps(job: Job) -> dict[str, Command]:
        return {name: [job.build / f"vasamesh_baseline_{name}", job.volume, job.surface, *options]}

    return steps


def poisson(job: Job) -> dict[str, Command]:
    points = job.scratch / "points.ply"
    return {
        "points": [job.build / "vasamesh_baseline_points", job.volume, points],
        "reconstruction": [
            sys.executable,
            PERF / "baselines" / "poisson_recon.py",
            points,
            job.surface,
        ],
    }


def subdivision(job: Job) -> dict[str, Command]:
    return {
        "subdivision": [
            sys.executable,
            "-B",
            "-m",
            "baselines.subdivision",
            job.volume,
            job.surface,
        ]
    }


METHODS = {
    "ours": Method("ours, adaptive", ours("adaptive"), ("vasamesh",)),
    "base": Method("ours, base surface", ours("base"), ("vasamesh",)),
    "mc": Method("marching cubes", baseline("mc"), ("vasamesh_baseline_mc",)),
    "mc-smooth": Method(
        "marching cubes, smoothed and decimated",
        baseline("mc", "--smooth"),
        ("vasamesh_baseline_mc",),
    ),
    "mpu": Method(
        "MPU implicits, tolerance 0.2 voxels", baseline("mpu"), ("vasamesh_baseline_mpu",)
    ),
    "mpu-smooth": Method(
        "MPU implicits, tolerance 0.8 voxels",
        baseline("mpu", "--tolerance", "0.8"),
        ("vasamesh_baseline_mpu",),
    ),
    "ss": Method(
        "subdivision surface",
        subdivision,
        (),
        (
            ("skimage", "scikit-image"),
            ("SimpleITK", "SimpleITK"),
            ("scipy", "scipy"),
            ("vtkmodules", "vtk"),
        ),
    ),
    "mesh3": Method("CGAL Mesh_3", baseline("mesh3"), ("vasamesh_baseline_mesh3",)),
    "psr": Method(
        "screened Poisson", poisson, ("vasamesh_baseline_points",), (("pymeshlab", "pymeshlab"),)
    ),
}

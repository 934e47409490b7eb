"""The subdivision-surface baseline on phantoms: closed, of their topology, near the exact surface.

subdivision_test.py VASAMESH PERF_FOLDER
"""

import importlib.util
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SKIP = 77
PACKAGES = ("numpy", "scipy", "skimage", "SimpleITK", "vtkmodules")
LIMIT = 0.5  # voxels, of the mean distance to the exact surface


class Subdivision(unittest.TestCase):
    program: str
    perf: str

    def run_program(self, *words: str) -> str:
        return subprocess.run(
            [self.program, *words], capture_output=True, text=True, check=False
        ).stdout

    def check_phantom(self, name: str, handles: int) -> None:
        with tempfile.TemporaryDirectory() as folder:
            volume, exact, surface = (f"{folder}/{file}" for file in ("a.nii.gz", "e.ply", "s.ply"))
            self.run_program("phantom", name, "-o", volume, "--surface", exact)
            subprocess.run(
                [sys.executable, "-m", "baselines.subdivision", volume, surface],
                cwd=self.perf,
                check=True,
            )
            report = json.loads(
                self.run_program(
                    "check", surface, "--against", volume, "--reference", exact, "--json"
                )
            )
        check = report["check"]
        for defect in ("open_edges", "nonmanifold_edges", "misoriented_edges", "inverted_shells"):
            self.assertEqual(check[defect], 0, defect)
        self.assertEqual(check["topology"], {"pieces": 1, "handles": handles, "cavities": 0})
        for way in ("to", "back"):
            self.assertLess(report["distance"][way]["mean_voxels"], LIMIT, way)

    def test_sphere(self) -> None:
        self.check_phantom("sphere", 0)

    def test_torus(self) -> None:
        self.check_phantom("torus", 1)

    def test_branch(self) -> None:
        self.check_phantom("y_branch", 0)


if __name__ == "__main__":
    missing = [package for package in PACKAGES if importlib.util.find_spec(package) is None]
    if missing:
        print(f"skipped: no Python package {', '.join(missing)} here; see perf/requirements.txt")
        sys.exit(SKIP)
    Subdivision.program, Subdivision.perf = sys.argv[1], sys.argv[2]
    unittest.main(argv=sys.argv[:1])

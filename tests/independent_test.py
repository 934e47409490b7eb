"""Distances against a tool that is not ours, PyPI's pymeshlab: within 1 %, both ways.

independent_test.py VASAMESH PERF_FOLDER
"""

import importlib.util
import json
import sys
import tempfile
import unittest
from pathlib import Path

SKIP = 77
WITHIN = 0.01
SAMPLES = 300_000


class Distances(unittest.TestCase):
    program: Path

    def run_program(self, *words: str | Path) -> str:
        import process

        outcome = process.run([self.program, *words])
        self.assertEqual(outcome.code, 0, outcome.error)
        return outcome.output

    def check_phantom(self, name: str, kind: str) -> None:
        """From our surface of a phantom to its exact one, and back."""
        from evaluation.independent import hausdorff

        with tempfile.TemporaryDirectory() as folder:
            volume, exact, ours = (Path(folder) / file for file in ("a.nii.gz", "e.ply", "o.ply"))
            self.run_program("phantom", name, "-o", volume, "--surface", exact)
            self.run_program("convert", volume, "-o", ours, "--surface", kind, "--quiet")
            words = ("check", ours, "--against", volume, "--reference", exact, "--json")
            mine = json.loads(self.run_program(*words))["distance"]
            theirs = {
                "to": hausdorff(ours, exact, SAMPLES),
                "back": hausdorff(exact, ours, SAMPLES),
            }
        for way in ("to", "back"):
            for figure in ("mean_mm", "rms_mm"):
                ratio = mine[way][figure] / theirs[way][figure]
                self.assertAlmostEqual(ratio, 1, delta=WITHIN, msg=f"{name} {way} {figure}")
            self.assertLess(theirs[way]["maximum_mm"], 1.02 * mine[way]["maximum_mm"])

    def test_torus(self) -> None:
        self.check_phantom("torus", "adaptive")

    def test_branch(self) -> None:
        self.check_phantom("y_branch", "adaptive")

    def test_aneurysm(self) -> None:
        self.check_phantom("aneurysm", "base")


if __name__ == "__main__":
    if importlib.util.find_spec("pymeshlab") is None:
        print("skipped: no Python package pymeshlab here; see perf/requirements.txt")
        sys.exit(SKIP)
    Distances.program = Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(Path(sys.argv[2]).resolve()))
    unittest.main(argv=sys.argv[:1], verbosity=2)

"""The systems that perf/compare sets beside ours, as it runs them, on shapes that are known: closed,
of their topology, near the exact surface. (MPU: mpu_test.)

baselines_test.py VASAMESH PERF_FOLDER
"""

import sys
import tempfile
import unittest
from pathlib import Path

SHAPES = ("sphere", "torus", "y_branch")
DEFECTS = ("open_edges", "nonmanifold_edges", "misoriented_edges", "inverted_shells")
TIMEOUT = 120  # seconds


class Baselines(unittest.TestCase):
    program: Path

    def check_method(self, method: str, limit: float) -> None:
        """On each shape a surface without holes, at most `limit` voxels away on average."""
        from evaluation.inputs import open_input
        from evaluation.measure import measure

        for shape in SHAPES:
            with self.subTest(shape), tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                given = open_input(shape, self.program, folder, set())
                row = measure(method, given, self.program.parent, folder, TIMEOUT)
                if row["status"] == "missing":
                    self.skipTest(row["reason"])
                self.assertEqual(row["status"], "done", row.get("reason"))
                for defect in DEFECTS:
                    self.assertEqual(row["check"][defect], 0, defect)
                self.assertEqual(row["check"]["topology"], row["check"]["wanted"])
                for way in ("to", "back"):
                    self.assertLess(row["exact"][way]["mean_voxels"], limit, way)

    def test_marching_cubes(self) -> None:
        self.check_method("mc", 0.25)

    def test_smoothed_marching_cubes(self) -> None:
        self.check_method("mc-smooth", 0.25)

    def test_mesh3(self) -> None:
        self.check_method("mesh3", 0.25)

    def test_screened_poisson(self) -> None:
        self.check_method("psr", 0.25)

    def test_subdivision(self) -> None:
        self.check_method("ss", 0.5)


if __name__ == "__main__":
    Baselines.program = Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(Path(sys.argv[2]).resolve()))
    unittest.main(argv=sys.argv[:1], verbosity=2)

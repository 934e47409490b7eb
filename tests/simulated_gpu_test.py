"""Kernels in the shape of a GPU, run by Oclgrind: a simulator that finds races between work-items,
barriers that not all of them reach, and accesses outside of buffers.

simulated_gpu_test.py VASAMESH ICD_OF_OCLGRIND
"""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PASSES = ("primitives_test", "bricks_test", "poisson_passes_test", "surface_test")


class SimulatedGpu(unittest.TestCase):
    program: Path
    icd: Path

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.log = self.folder / "oclgrind.log"
        (self.folder / "oclgrind.icd").write_text(f"{self.icd}\n")
        self.environment = os.environ | {
            "OCL_ICD_VENDORS": str(self.folder),
            "XDG_CACHE_HOME": str(self.folder / "cache"),
            "OCLGRIND_BUILD_OPTIONS": "-cl-opt-disable",  # it lacks what its optimiser makes
            "OCLGRIND_DATA_RACES": "1",
            "OCLGRIND_LOG": str(self.log),
        }

    def run_simulated(self, *command: str | Path) -> str:
        """What the command prints. Fails where the command fails or Oclgrind finds anything."""
        result = subprocess.run(command, env=self.environment, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(self.log.read_text() if self.log.exists() else "", "")
        return result.stdout

    def test_passes(self) -> None:
        for name in PASSES:
            with self.subTest(name):
                program = self.program.parent / name
                printed = self.run_simulated(program, "--gtest_filter=*opencl_work_group*")
                self.assertRegex(printed, r"PASSED  \] [1-9]")
                self.assertNotIn("SKIPPED", printed)

    def test_a_conversion(self) -> None:
        volume, surface = self.folder / "ball.nii", self.folder / "opencl.ply"
        subprocess.run([self.program, "phantom", "sphere", "--radius", "3", "-o", volume], check=True)
        self.assertRegex(self.run_simulated(self.program, "devices"), "opencl +gpu")
        self.run_simulated(self.program, "convert", volume, "-o", surface, "--backend", "opencl")
        wanted = self.folder / "tbb.ply"
        subprocess.run(
            [self.program, "convert", volume, "-o", wanted, "--backend", "tbb", "-q"], check=True
        )
        self.assertEqual(surface.read_bytes(), wanted.read_bytes())

    def test_a_race_would_be_found(self) -> None:
        (self.folder / "racy.cl").write_text(
            "kernel void racy(global int *sum) { *sum += (int)get_global_id(0); }\n"
        )
        launch = self.folder / "racy.sim"
        launch.write_text("racy.cl\nracy\n4 1 1\n4 1 1\n<size=4 fill=0>\n")
        subprocess.run(["oclgrind-kernel", launch], env=self.environment, cwd=self.folder, check=True)
        self.assertIn("data race", self.log.read_text())


if __name__ == "__main__":
    SimulatedGpu.program, SimulatedGpu.icd = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    if not SimulatedGpu.icd.is_file():
        print("Oclgrind is not here")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)

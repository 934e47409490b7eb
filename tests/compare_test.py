"""perf/compare: tables and judgements of known rows, methods that fail, a whole run on a phantom,
and its page in a headless browser.

    compare_test.py VASAMESH PERF_FOLDER
"""

import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

DRAWING = ("matplotlib", "numpy", "PIL", "pyvista", "vtkmodules")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def row_of(
    method: str, triangles: int = 100, mean: float = 0.1, spread: float = 1.0, **check: Any
) -> dict[str, Any]:
    """A finished row, of a surface that is as asked for unless `check` says otherwise."""
    way = {
        "mean_mm": mean,
        "maximum_mm": 1.0,
        "rms_mm": mean,
        "mean_voxels": mean,
        "maximum_voxels": 1.0,
        "rms_voxels": mean,
    }
    topology = {"pieces": 1, "handles": 2, "cavities": 0}
    shape = {
        "mean": 0.9,
        "deviation": 0.1,
        "minimum": 20.0,
        "percentile_5": 30.0,
        "percentile_95": 1.2,
    }
    report = {
        "vertices": triangles // 2 + 2,
        "triangles": triangles,
        "passed": True,
        "topology": topology,
        "wanted": topology,
        "mismatched_pieces": 0,
        "open_edges": 0,
        "nonmanifold_edges": 0,
        "nonmanifold_vertices": 0,
        "misoriented_edges": 0,
        "inverted_shells": 0,
        "intersecting_pairs": 0,
        "degenerate_triangles": 0,
    }
    return {
        "method": method,
        "status": "done",
        "stages": {"all": 1.0},
        "wall": 1.0,
        "cpu": 1.0,
        "peak": 10**6,
        "check": {**report, **check},
        "distance": {"to": way, "back": way},
        "rms_curvature": {
            "mean": 1.0,
            "percentile_5": 0.5,
            "median": 1.0,
            "percentile_95": 0.5 + spread,
        },
        "quality": {
            "edge_ratio": shape,
            "least_angle": shape,
            "size_ratio": shape,
            "edge_ratio_above_08": 0.9,
            "edge_ratio_below_03": 0.0,
            "edge_ratio_below_01": 0.0,
            "sharp_edges": 0,
        },
    }


class Judgement(unittest.TestCase):
    def met(self, rows: list[dict[str, Any]], radius: float | None = 3.0) -> dict[str, bool]:
        from evaluation.goals import goals_of

        return {
            goal.text: goal.met for goal in goals_of({row["method"]: row for row in rows}, radius)
        }

    def test_all_goals_met(self) -> None:
        goals = self.met(
            [
                row_of("ours", 80, 0.1, 0.4),
                row_of("mc", 100, 0.0, 1.0, intersecting_pairs=1),
                row_of("mpu", 90, 0.1, 0.4, open_edges=1, passed=False),
            ]
        )
        self.assertTrue(all(goals.values()), goals)
        self.assertIn("20 % fewer triangles than mc", goals)
        self.assertIn("11 % fewer triangles than mpu", goals)

    def test_what_is_worse_is_not_met(self) -> None:
        goals = self.met(
            [
                row_of("ours", 110, 0.2, 0.6),
                row_of("mc", 100, 0.0, 1.0),
                row_of("mpu", 100, 0.1, 0.5),
            ],
            1.5,
        )
        missed = [text for text, met in goals.items() if not met]
        self.assertIn("mc, mpu has all three too", missed)
        self.assertTrue(
            any(text.startswith("10 % more triangles than mc (not asked for") for text in missed),
            missed,
        )
        self.assertIn("mean distance to marching cubes 0.200 voxels, mpu's 0.100", missed)
        self.assertIn("spread of the RMS curvature 0.60 /mm, mpu's 0.50", missed)

    def test_the_exact_surface_stands_beside_the_spread(self) -> None:
        from evaluation.goals import goals_of

        rows = {"ours": row_of("ours", spread=0.8), "mc": row_of("mc", spread=1.0)}
        exact = row_of("exact", spread=0.7)
        text = goals_of(rows, 3.0, exact)[-1].text
        self.assertIn("0.80 of marching cubes' (at most 0.5); the exact surface's is 0.70", text)

    def test_each_defect_spoils_ours(self) -> None:
        from evaluation.goals import complete

        self.assertTrue(complete(row_of("ours")))
        for defect in (
            "open_edges",
            "nonmanifold_edges",
            "intersecting_pairs",
            "mismatched_pieces",
        ):
            self.assertFalse(complete(row_of("ours", passed=False, **{defect: 1})), defect)
        row = row_of("ours")
        row["quality"]["edge_ratio_above_08"] = 0.75
        self.assertFalse(complete(row))

    def test_a_better_baseline_is_named(self) -> None:
        from evaluation.goals import better_than_ours

        found = better_than_ours(
            {
                "ours": row_of("ours", 100),
                "mc": row_of("mc", 120, 0.0),
                "mpu": row_of("mpu", 90, 0.05),
            }
        )
        self.assertEqual(found["triangles"], ["mpu"])
        self.assertEqual(found["mean distance to marching cubes"], ["mpu"])
        self.assertNotIn("curvature spread", found)


class Tables(unittest.TestCase):
    def test_the_best_is_bold_and_a_failure_says_why(self) -> None:
        from evaluation.tables import SIZE, figures, markdown_table

        failed = {"method": "ss", "status": "timed out", "reason": "not done after 5 s"}
        text = markdown_table(figures([row_of("ours", 90), failed, row_of("mc", 2000)], SIZE))
        self.assertIn("| ours | **47** | **90** |", text)
        self.assertIn("| mc | 1,002 | 2,000 |", text)
        self.assertIn("| ss | timed out: not done after 5 s |", text)
        self.assertEqual({line.count("|") for line in text.strip().splitlines()}, {7})

    def test_html_is_escaped(self) -> None:
        from evaluation.tables import Section, Table, html_sections

        text = html_sections([Section("a < b", table=Table(["x"], [["**1** <i>"]]))], str)
        self.assertIn("a &lt; b", text)
        self.assertIn("<td><b>1</b> &lt;i&gt;</td>", text)


class Running(unittest.TestCase):
    program: Path

    def run_method(self, command: list[str], timeout: float = 60) -> dict[str, Any]:
        from evaluation.measure import run_steps
        from evaluation.methods import Job, Method

        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            job = Job(folder, folder / "v", folder / "s.ply", folder / "r", folder)
            return run_steps("a", Method("a", lambda _: {"step": command}), job, timeout)

    def test_a_failure_gives_its_last_line(self) -> None:
        row = self.run_method(["sh", "-c", "echo one >&2; echo the reason >&2; exit 3"])
        self.assertEqual((row["status"], row["reason"]), ("failed", "the reason"))

    def test_no_surface_is_a_failure(self) -> None:
        self.assertEqual(self.run_method(["true"])["reason"], "no surface was written")

    def test_a_method_ends_at_its_limit_with_all_it_started(self) -> None:
        row = self.run_method(["sh", "-c", "sleep 50; true"], 0.2)
        self.assertEqual((row["status"], row["reason"]), ("timed out", "not done after 0.2 s"))

    def test_what_is_missing_is_named(self) -> None:
        from evaluation.methods import METHODS, Method

        self.assertIn("-DVASAMESH_BASELINES=ON", METHODS["mc"].missing(Path("/nowhere")))
        absent = Method("a", lambda _: {}, (), (("no_such_module", "such-package"),))
        self.assertIn("pip install such-package", absent.missing(Path("/nowhere")))

    def test_memory_is_that_of_the_process(self) -> None:
        import process

        ballast = bytearray(200_000_000)
        self.assertLess(process.run_apart(["true"]).peak, 50_000_000)
        use = [sys.executable, "-c", "a = b'1' * 90_000_000"]
        self.assertGreater(process.run_apart(use).peak, 90_000_000)
        self.assertEqual(len(ballast), 200_000_000)


class WholeRun(unittest.TestCase):
    program: Path
    perf: Path
    folder: tempfile.TemporaryDirectory

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.run_result = cls.compare("sphere", "-o", cls.folder.name, "--methods", "ours,mc,mpu")

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    @classmethod
    def compare(cls, *words: str) -> subprocess.CompletedProcess:
        return subprocess.run(
            [sys.executable, "-B", cls.perf / "compare", *words, "--build", cls.program.parent],
            capture_output=True,
            text=True,
            check=False,
        )

    def text_of(self, name: str) -> str:
        return (Path(self.folder.name) / name).read_text()

    def test_ends_well_with_a_row_a_method(self) -> None:
        self.assertEqual(self.run_result.returncode, 0, self.run_result.stderr)
        content = json.loads(self.text_of("report.json"))
        rows = {row["method"]: row for row in content["inputs"][0]["methods"]}
        self.assertEqual(list(rows), ["ours", "mc", "mpu"])
        self.assertTrue(rows["ours"]["check"]["passed"])
        self.assertLess(rows["ours"]["exact"]["to"]["mean_voxels"], 0.25)
        for row in rows.values():
            if row["status"] != "done":
                self.assertIn("VASAMESH_BASELINES", row["reason"])

    def test_report_has_every_table(self) -> None:
        text = self.text_of("report.md")
        for title in (
            "Data sets",
            "What is asked of ours",
            "Size and cost",
            "Distance to marching cubes",
            "Distance to the exact surface",
            "Smoothness",
            "Triangle quality",
            "Topology",
            "The exact surface's: mean",
            "The exact surface itself: mean",
        ):
            self.assertIn(title, text)

    def test_bad_input_and_wrong_use(self) -> None:
        outcome = self.compare("no_such_thing", "-o", self.folder.name)
        self.assertEqual(outcome.returncode, 3)
        self.assertIn("no_such_thing: no such file, and no phantom", outcome.stderr)
        for words in (
            ("-o", "x", "--methods", "magic"),
            ("-o", __file__),
            ("-o", self.folder.name, "--keep", __file__),
            ("-o", self.folder.name, "--timeout", "0"),
            ("-o", self.folder.name, "--timeout", "nan"),
            ("-o", self.folder.name, "--page-triangles", "-1"),
        ):
            outcome = self.compare("sphere", *words)
            self.assertEqual(outcome.returncode, 2, words)
            self.assertNotIn("Traceback", outcome.stderr)

    def test_inputs_of_one_name_are_told_apart(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            scans = [folder / which / "scan.nii.gz" for which in ("a", "b")]
            for scan, shape in zip(scans, ("sphere", "torus")):
                scan.parent.mkdir()
                subprocess.run([self.program, "phantom", shape, "-o", scan], check=True)
            words = ("-o", folder / "out", "--methods", "ours, ours", "--tables-only")
            self.assertEqual(self.compare(*map(str, scans + list(words))).returncode, 0)
            inputs = json.loads((folder / "out" / "report.json").read_text())["inputs"]
        self.assertEqual([given["name"] for given in inputs], ["scan", "scan-2"])
        self.assertEqual([len(given["methods"]) for given in inputs], [1, 1])
        handles = [given["methods"][0]["check"]["topology"]["handles"] for given in inputs]
        self.assertEqual(handles, [0, 1])

    def test_histograms_add_up(self) -> None:
        rows = json.loads(self.text_of("report.json"))["inputs"][0]["methods"]
        if "histograms" not in rows[0]:
            self.skipTest("no Python packages to read surfaces with")
        for name in ("rms_curvature", "edge_ratio", "least_angle"):
            self.assertAlmostEqual(sum(rows[0]["histograms"][name]), 1, places=2)

    def test_the_page_runs_in_a_browser(self) -> None:
        page = Path(self.folder.name) / "report.html"
        browser = next(filter(None, map(shutil.which, BROWSERS)), None)
        if not page.exists():
            self.skipTest("no page: " + self.run_result.stderr.strip())
        if browser is None:
            self.skipTest("no browser; install Debian's chromium")
        outcome = subprocess.run(
            [
                browser,
                "--headless",
                "--no-sandbox",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                f"--user-data-dir={self.folder.name}/profile",
                "--enable-logging=stderr",
                "--virtual-time-budget=8000",
                "--dump-dom",
                page.as_uri(),
            ],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        console = [line for line in outcome.stderr.splitlines() if ":CONSOLE" in line]
        self.assertEqual(console, [])
        first = re.search(r"<html[^>]*>", outcome.stdout)
        self.assertIsNotNone(first, outcome.stderr[-2000:])
        self.assertIn('data-state="ready"', first.group())
        drawn = re.search(r'data-drawn="(\d+)"', first.group())
        triangles = json.loads(self.text_of("report.json"))["inputs"][0]["methods"][0]
        self.assertGreaterEqual(int(drawn.group(1)), triangles["check"]["triangles"])


class Pictures(unittest.TestCase):
    def test_a_reference_beside_a_volume_is_turned_to_lps(self) -> None:
        if importlib.util.find_spec("vtkmodules") is None:
            self.skipTest("no vtkmodules here; see perf/requirements.txt")
        from evaluation.inputs import reference_beside
        from vtkmodules.vtkFiltersSources import vtkPlaneSource
        from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
        from vtkmodules.vtkIOPLY import vtkPLYReader

        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            self.assertIsNone(reference_beside(folder / "scan.nii.gz", folder / "copy.ply"))
            plane, writer, reader = vtkPlaneSource(), vtkPolyDataWriter(), vtkPLYReader()
            plane.SetOrigin(1, 2, 3)
            plane.SetPoint1(5, 2, 3)
            plane.SetPoint2(1, 7, 3)
            writer.SetInputConnection(plane.GetOutputPort())
            writer.SetFileName(str(folder / "scan.vtk"))
            writer.Write()
            reader.SetFileName(str(reference_beside(folder / "scan.nii.gz", folder / "copy.ply")))
            reader.Update()
        self.assertEqual(reader.GetOutput().GetBounds(), (-5, -1, -7, -2, 3, 3))

    def test_shares_of_known_values(self) -> None:
        if any(importlib.util.find_spec(name) is None for name in DRAWING):
            self.skipTest("no " + ", ".join(DRAWING) + " here; see perf/requirements.txt")
        import numpy as np
        from evaluation.surfaces import KEPT, SurfaceMap, histograms, in_ball

        surface = SurfaceMap(
            np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]]),
            np.array([[0, 1, 2], [1, 2, 3]]),
            np.array([0.1, 0.1, 5.0, 1.9]),
            np.array([1.0, 1, 1, 1]),
            np.array([0.5, 1.0]),
            np.array([30.0, 60]),
        )
        found = histograms(surface, 2.0)
        self.assertAlmostEqual(found["rms_curvature"][int(0.1 / 2 * KEPT)], 0.5)
        self.assertAlmostEqual(found["rms_curvature"][-1], 0.25)  # beyond the scale
        self.assertAlmostEqual(found["edge_ratio"][-1], 0.5)
        self.assertEqual(in_ball(surface, np.array([0, 0, 0]), 0.5).tolist(), [True, False])


if __name__ == "__main__":
    Running.program = WholeRun.program = Path(sys.argv[1]).resolve()
    WholeRun.perf = Path(sys.argv[2]).resolve()
    sys.path.insert(0, str(WholeRun.perf))
    unittest.main(argv=sys.argv[:1], verbosity=2)

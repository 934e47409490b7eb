"""perf/table.py: limits and tables of known rows, and a whole run on phantoms.

table_test.py VASAMESH PERF_FOLDER
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

DEFECTS = (
    "open_edges",
    "nonmanifold_edges",
    "misoriented_edges",
    "nonmanifold_vertices",
    "isolated_vertices",
    "degenerate_triangles",
    "nonfinite_vertices",
    "intersecting_pairs",
    "inverted_shells",
    "mismatched_pieces",
)


def row_of(kind: str = "data", **changes: Any) -> dict[str, Any]:
    """A measured row within all limits, unless `changes` say otherwise: of the row itself or, by
    the same name, of its check or quality."""
    topology = {"pieces": 1, "handles": 2, "cavities": 0}
    way = {"mean_voxels": 0.1, "rms_voxels": 0.1, "largest_mm": 0.5}
    row = {
        "label": "a",
        "kind": kind,
        "accurate": False,
        "wall": 1.0,
        "cpu": 1.0,
        "peak": 10**8,
        "stages": {"read": 0.1},
        "spacing": [0.8, 0.8, 1.0],
        "median_radius": 2.5,
        "marching_cubes": 1000,
        "same_bytes": True,
        "mesh": {"hard_share": 0.1, "base_share": 0, "attempts": 1},
        "distance": {"to": way, "back": way},
        "check": {
            "triangles": 700,
            "topology": topology,
            "wanted": topology,
            "passed": True,
            "reason": "",
            **dict.fromkeys(DEFECTS, 0),
        },
        "quality": {
            "edge_ratio_above_08": 0.9,
            "edge_ratio_below_03": 0,
            "edges_within_15": 0.995,
            "sharp_edges": 0,
            "least_angle": {"minimum": 25, "percentile_5": 45, "mean": 50},
            "edge_ratio": {"mean": 0.9},
            "size_ratio": {"mean": 1.1},
        },
    }
    for name, value in changes.items():
        part = next((row[p] for p in ("check", "quality") if name in row[p]), row)
        part[name] = value
    return row


class Limits(unittest.TestCase):
    def outside(self, kind: str = "adaptive", **changes: Any) -> list[str]:
        from table_figures import outside

        return outside(kind, row_of(**changes))

    def test_each_limit(self) -> None:
        self.assertEqual(self.outside(), [])
        for changes, words in (
            ({"edge_ratio_above_08": 0.749}, "triangles with tau of 0.8 or more, %: 74.9 below 75"),
            ({"edge_ratio_below_03": 2 / 700}, "triangles with tau below 0.3: 2 above 0"),
            ({"least_angle": {"minimum": 19.9, "percentile_5": 45}}, "least angle, degrees: 19.9"),
            ({"least_angle": {"minimum": 21, "percentile_5": 39}}, "5th percentile of the least"),
            ({"sharp_edges": 3}, "edges with a dihedral angle below 60 degrees: 3 above 2"),
            ({"edges_within_15": 0.98}, "neighbouring edges within a ratio of 1.5, %: 98.00 below"),
            ({"triangles": 810}, "triangles over marching cubes': 0.81 above 0.80"),
            ({"spacing": [0.4, 0.4, 0.5]}, "largest distance to marching cubes, mm: 0.500 above"),
            ({"open_edges": 3}, "3 open_edges"),
            ({"same_bytes": False}, "bytes differ by threads"),
            ({"base_peak": 8 * 10**7}, "peak memory over the base surface's: 1.25 above 1.20"),
        ):
            found = self.outside(**changes)
            self.assertTrue(found and found[0].startswith(words), (found, words))

    def test_thin_vessels_may_have_as_many_triangles_as_marching_cubes(self) -> None:
        self.assertEqual(self.outside(triangles=990, median_radius=1.9), [])
        self.assertEqual(len(self.outside(triangles=1010, median_radius=1.9)), 1)
        self.assertEqual(self.outside(kind="base", triangles=9000), [])

    def test_of_phantoms_no_number_of_triangles_is_asked(self) -> None:
        from table_figures import outside

        self.assertEqual(outside("adaptive", row_of("tree", triangles=2000)), [])


class Text(unittest.TestCase):
    def test_what_is_outside_is_bold_and_counted(self) -> None:
        from table_figures import outside
        from table_text import markdown

        rows = [row_of(), row_of(label="b", edge_ratio_above_08=0.5)]
        rows.append(row_of(label="noise", mesh={"hard_share": 0, "base_share": 1, "attempts": 2}))
        rows.append({"label": "c", "kind": "data", "outside": ["convert ended with 4: why"]})
        for row in rows[:3]:
            row["outside"] = outside("adaptive", row)
        head = {"surface": "adaptive", "version": "v", "machine": "m", "load": 1}
        text = markdown({**head, "rows": rows})
        self.assertIn("1 of 4 inputs are within all limits", text)
        self.assertIn("| at least 75 | 3 | **1** | **50.0** (b) |", text)
        self.assertIn("- **noise (base surface)**: share of the base surface", text)
        self.assertIn("- **c**: convert ended with 4: why", text)


class WholeRun(unittest.TestCase):
    program: Path
    perf: Path

    def test_of_a_sphere(self) -> None:
        if not (self.program.parent / "vasamesh_cases").exists():
            self.skipTest("no vasamesh_cases: built with -DVASAMESH_BUILD_BENCHMARKS=ON")
        for surface in ("adaptive", "base"):
            with tempfile.TemporaryDirectory() as folder:
                words = ["--surface", surface, "--trees", "0", "--only", "^sphere$"]
                words += ["--program", self.program, "-o", f"{folder}/figures"]
                script = [sys.executable, "-B", self.perf / "table.py", *words]
                outcome = subprocess.run(script, capture_output=True, text=True, check=False)
                self.assertEqual(outcome.returncode, 0, outcome.stderr)
                content = json.loads(Path(f"{folder}/figures.json").read_text())
                text = Path(f"{folder}/figures.md").read_text()
            self.assertEqual([row["label"] for row in content["rows"]], ["sphere"])
            self.assertLess(content["rows"][0]["exact"]["to"]["mean_voxels"], 0.12)
            self.assertIn("All 1 inputs are within all limits.", text)


if __name__ == "__main__":
    WholeRun.program = Path(sys.argv[1]).resolve()
    WholeRun.perf = Path(sys.argv[2]).resolve()
    sys.path.insert(0, str(WholeRun.perf))
    unittest.main(argv=sys.argv[:1], verbosity=2)

"""The figures of perf/table.py that have limits, and which are outside."""

from dataclasses import dataclass
from typing import Any, Callable

Row = dict[str, Any]
Number = Callable[[Row], float | None]  # None: the row has no such figure, or no limit for it

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
THICK = 2  # voxels, of the median inscribed radius
PEAKS = {"cerebral": 1000, "airways": 3000}  # MB, of the base surface


@dataclass(frozen=True)
class Figure:
    """One number of a row, at most or at least its limit."""

    name: str
    title: str  # of its column
    value: Number
    form: str
    limit: Number
    words: str  # the limit, for the reader
    sign: int = 1  # 1: the limit is the most that is allowed, -1: the least

    def cell(self, row: Row) -> str:
        """The value; bold where it is outside."""
        value = self.value(row)
        if value is None:
            return "-"
        text = self.form.format(value)
        return f"**{text}**" if self.outside(row) else text

    def excess(self, row: Row) -> float | None:
        """How far beyond the limit, as a fraction of it where it is not 0; None: not judged."""
        value, limit = self.value(row), self.limit(row)
        if value is None or limit is None:
            return None
        return self.sign * (value - limit) / (limit or 1)

    def outside(self, row: Row) -> bool:
        excess = self.excess(row)
        return excess is not None and excess > 0

    def complaint(self, row: Row) -> str:
        word = "above" if self.sign > 0 else "below"
        return (
            f"{self.name}: {self.form.format(self.value(row))} {word} "
            f"{self.form.format(self.limit(row))}"
        )


def always(limit: float) -> Number:
    return lambda row: limit


def largest_limit(row: Row) -> float:
    """How far the surface may be from marching cubes, mm."""
    return max(min(row["spacing"]), 0.55 * max(row["spacing"]))


def mean_limit(row: Row) -> float:
    return 0.17 if row["kind"] == "data" else 0.27


def where_accurate(limit: float) -> Number:
    return lambda row: limit if row["accurate"] else None


def distance(key: str, way: str, name: str) -> Number:
    return lambda row: row[key][way][name] if key in row else None


def quality(name: str, *path: str) -> Number:
    def value(row: Row) -> float:
        found = row["quality"][name]
        for part in path:
            found = found[part]
        return found

    return value


def percent(value: Number) -> Number:
    def scaled(row: Row) -> float | None:
        found = value(row)
        return None if found is None else 100 * found

    return scaled


DISTANCES = [
    *(
        Figure(
            f"mean distance {way} marching cubes, voxel",
            f"mean {short}, voxel",
            distance("distance", short, "mean_voxels"),
            "{:.3f}",
            mean_limit,
            "0.17 on real volumes, 0.27 on phantoms",
        )
        for way, short in (("to", "to"), ("back from", "back"))
    ),
    *(
        Figure(
            f"largest distance {way} marching cubes, mm",
            f"largest {short}, mm",
            distance("distance", short, "largest_mm"),
            "{:.3f}",
            largest_limit,
            "the smallest spacing, or 0.55 of the largest if that is more",
        )
        for way, short in (("to", "to"), ("back from", "back"))
    ),
]

ACCURATE = "where the exact surface is known and no radius is below 2.5 voxels"
EXACT_MEANS = [
    Figure(
        f"mean distance {way} the exact surface, voxel",
        f"mean {short}, voxel",
        distance("exact", short, "mean_voxels"),
        "{:.3f}",
        where_accurate(0.12),
        f"0.12, {ACCURATE}",
    )
    for way, short in (("to", "to"), ("back from", "back"))
]
EXACT_VOLUME = Figure(
    "volume off the exact one's, %",
    "volume off, %",
    lambda row: 100 * abs(row["exact"]["volume_error"]) if "exact" in row else None,
    "{:.2f}",
    where_accurate(2),
    f"2, {ACCURATE}",
)


def cubes_share(row: Row) -> float:
    """Triangles over those of marching cubes."""
    return row["check"]["triangles"] / row["marching_cubes"]


def cubes_limit(row: Row) -> float | None:
    if row["kind"] != "data":
        return None
    radius = row.get("median_radius")
    return 0.8 if radius is not None and radius >= THICK else 1


SHAPES = [
    Figure(
        "triangles over marching cubes'",
        "triangles over marching cubes'",
        cubes_share,
        "{:.2f}",
        cubes_limit,
        "on real volumes 1; 0.8 where the median inscribed radius is 2 voxels or more",
    ),
    Figure(
        "triangles with tau of 0.8 or more, %",
        "tau of 0.8 or more, %",
        percent(quality("edge_ratio_above_08")),
        "{:.1f}",
        always(75),
        "75",
        -1,
    ),
    Figure(
        "triangles with tau below 0.3",
        "tau below 0.3",
        lambda row: round(row["quality"]["edge_ratio_below_03"] * row["check"]["triangles"]),
        "{:,}",
        always(0),
        "0",
    ),
    Figure(
        "least angle, degrees",
        "least angle",
        quality("least_angle", "minimum"),
        "{:.1f}",
        always(20),
        "20",
        -1,
    ),
    Figure(
        "5th percentile of the least angles, degrees",
        "5th percentile",
        quality("least_angle", "percentile_5"),
        "{:.1f}",
        always(40),
        "40",
        -1,
    ),
    Figure(
        "edges with a dihedral angle below 60 degrees",
        "sharp edges",
        quality("sharp_edges"),
        "{:,}",
        always(2),
        "2",
    ),
    Figure(
        "neighbouring edges within a ratio of 1.5, %",
        "edges within 1.5, %",
        percent(quality("edges_within_15")),
        "{:.2f}",
        always(99),
        "99",
        -1,
    ),
    Figure(
        "share of the base surface, %",
        "base share, %",
        lambda row: 100 * row["mesh"]["base_share"],
        "{:.2f}",
        always(0),
        "0",
    ),
]

MEMORY = {
    "adaptive": Figure(
        "peak memory over the base surface's",
        "peak over the base surface's",
        lambda row: row["peak"] / row["base_peak"] if "base_peak" in row else None,
        "{:.2f}",
        always(1.2),
        "1.2, measured on large trees and real volumes",
    ),
    "base": Figure(
        "peak memory, MB",
        "peak, MB",
        lambda row: row["peak"] / 1e6,
        "{:.0f}",
        lambda row: PEAKS.get(row["label"]),
        "1000 for `cerebral`, 3000 for `airways`",
    ),
}


def figures_of(surface: str) -> list[Figure]:
    """All that have limits, of a kind of surface."""
    shapes = SHAPES if surface == "adaptive" else []
    return [*DISTANCES, *EXACT_MEANS, EXACT_VOLUME, *shapes, MEMORY[surface]]


def outside(surface: str, row: Row) -> list[str]:
    """What is wrong with a measured row, in words."""
    check = row["check"]
    found = [f"{check[name]} {name}" for name in DEFECTS if check[name]]
    if check["topology"] != check["wanted"]:
        found.append("topology")
    if not check["passed"] and not found:
        found.append(check["reason"])
    if not row["same_bytes"]:
        found.append("bytes differ by threads or backends")
    return found + [f.complaint(row) for f in figures_of(surface) if f.outside(row)]

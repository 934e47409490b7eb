"""What the evaluation asks of our surface, and where another method is better."""

from dataclasses import dataclass
from typing import Any, Callable

Row = dict[str, Any]

GOOD_SHARE = 0.75  # of triangles with an edge ratio of 0.8 or more
THICK = 2  # voxels, of the median inscribed radius: from there on fewer triangles than others
HALF = 0.5
MPU = ("mpu", "mpu-smooth")


@dataclass(frozen=True)
class Goal:
    text: str
    met: bool


def right_topology(row: Row) -> bool:
    """The segmentation's, on a surface that is one: closed, manifold, outward."""
    return bool(row["check"]["passed"]) or (
        row["check"]["topology"] == row["check"]["wanted"]
        and not any(
            row["check"][defect]
            for defect in (
                "mismatched_pieces",
                "open_edges",
                "nonmanifold_edges",
                "nonmanifold_vertices",
                "misoriented_edges",
                "inverted_shells",
            )
        )
    )


def complete(row: Row) -> bool:
    """Topology, no self-intersection and well-shaped triangles at once."""
    return (
        right_topology(row)
        and row["check"]["intersecting_pairs"] == 0
        and row["quality"]["edge_ratio_above_08"] > GOOD_SHARE
    )


def spread(row: Row) -> float:
    curvature = row["rms_curvature"]
    return float(curvature["percentile_95"] - curvature["percentile_5"])


def fewer(ours: Row, other: Row) -> float:
    """How many of the other's triangles we save, as a fraction."""
    return float(1 - ours["check"]["triangles"] / other["check"]["triangles"])


def size_goals(ours: Row, rows: dict[str, Row], radius: float | None) -> list[Goal]:
    goals = []
    for name in ("mc", *MPU):
        if name not in rows:
            continue
        saved = fewer(ours, rows[name])
        text = (
            f"{100 * saved:.0f} % fewer triangles than {name}"
            if saved >= 0
            else f"{-100 * saved:.0f} % more triangles than {name}"
        )
        if radius is not None and radius < THICK:
            text += f" (not asked for: the median inscribed radius is {radius:.1f} voxels)"
        goals.append(Goal(text, saved > 0))
    return goals


def mpu_goals(ours: Row, mpu: Row, name: str) -> list[Goal]:
    goals = []
    for key, surface in (("distance", "marching cubes"), ("exact", "the exact surface")):
        if key not in ours or key not in mpu:
            continue
        for way, title in (("to", f"to {surface}"), ("back", f"back from {surface}")):
            mine, theirs = (row[key][way]["mean_voxels"] for row in (ours, mpu))
            goals.append(
                Goal(
                    f"mean distance {title} {mine:.3f} voxels, {name}'s {theirs:.3f}",
                    mine <= theirs,
                )
            )
    goals.append(
        Goal(
            f"spread of the RMS curvature {spread(ours):.2f} /mm, {name}'s " f"{spread(mpu):.2f}",
            spread(ours) <= spread(mpu),
        )
    )
    return goals


def goals_of(rows: dict[str, Row], radius: float | None, exact: Row | None = None) -> list[Goal]:
    """For one input's finished rows by method, ours among them, and the figures of the exact surface
    where it is known."""
    ours = rows["ours"]
    others = [name for name, row in rows.items() if name not in ("ours", "base") and complete(row)]
    goals = [
        Goal(
            "the segmentation's topology, no self-intersection and an edge ratio of 0.8 or more"
            f" in {100 * ours['quality']['edge_ratio_above_08']:.0f} % of the triangles",
            complete(ours),
        ),
        Goal(
            (
                "no other method has all three"
                if not others
                else f"{', '.join(others)} has all three too"
            ),
            not others,
        ),
    ]
    goals += size_goals(ours, rows, radius)
    for name in MPU:
        if name in rows:
            goals += mpu_goals(ours, rows[name], name)
    if "mc" in rows:
        cubes = max(spread(rows["mc"]), 1e-12)
        share = spread(ours) / cubes
        text = f"spread of the RMS curvature {share:.2f} of marching cubes' (at most {HALF})"
        if exact:
            text += f"; the exact surface's is {spread(exact) / cubes:.2f} of it"
        goals.append(Goal(text, share <= HALF))
    return goals


FIGURES: tuple[tuple[str, Callable[[Row], float | None]], ...] = (
    ("time", lambda r: r["wall"]),
    ("peak memory", lambda r: r["peak"]),
    ("triangles", lambda r: r["check"]["triangles"]),
    ("self-intersections", lambda r: r["check"]["intersecting_pairs"]),
    ("mean distance to marching cubes", lambda r: r["distance"]["to"]["mean_mm"]),
    ("mean distance back from it", lambda r: r["distance"]["back"]["mean_mm"]),
    ("largest distance to marching cubes", lambda r: r["distance"]["to"]["maximum_mm"]),
    ("largest distance back from it", lambda r: r["distance"]["back"]["maximum_mm"]),
    (
        "mean distance to the exact surface",
        lambda r: r["exact"]["to"]["mean_mm"] if "exact" in r else None,
    ),
    (
        "mean distance back from it (exact)",
        lambda r: r["exact"]["back"]["mean_mm"] if "exact" in r else None,
    ),
    ("share of edge ratios of 0.8 and above", lambda r: -r["quality"]["edge_ratio_above_08"]),
    ("mean edge ratio", lambda r: -r["quality"]["edge_ratio"]["mean"]),
    ("least angle of all", lambda r: -r["quality"]["least_angle"]["minimum"]),
    ("5th percentile of least angles", lambda r: -r["quality"]["least_angle"]["percentile_5"]),
    ("95th percentile of size ratios", lambda r: r["quality"]["size_ratio"]["percentile_95"]),
    ("curvature spread", spread),
)


def better_than_ours(rows: dict[str, Row]) -> dict[str, list[str]]:
    """For each figure the methods that beat ours in it; `base` is ours too. Marching cubes is the
    reference of its own distances, and left out of them."""
    found = {}
    for title, figure in FIGURES:
        mine = figure(rows["ours"])
        if mine is None:
            continue
        names = [
            name
            for name, row in rows.items()
            if name not in ("ours", "base")
            and (value := figure(row)) is not None
            and value < mine
            and not (name == "mc" and "distance" in title and "exact" not in title)
        ]
        if names:
            found[title] = names
    return found

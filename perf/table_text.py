"""The figures of perf/table.py as Markdown and JSON."""

import json
from typing import Any, Callable, Iterable

from table_figures import (
    DISTANCES,
    EXACT_MEANS,
    EXACT_VOLUME,
    MEMORY,
    SHAPES,
    Figure,
    Row,
    figures_of,
    largest_limit,
)

KINDS = (
    ("small", "Phantoms"),
    ("accuracy", "Phantoms of other spacings and radii"),
    ("large", "Large trees"),
    ("data", "Real volumes"),
    ("tree", "Random trees"),
)

INTRODUCTION = """\
# Figures of the {surface} surface

Written by `perf/table.py --surface {surface}` with {version} on a {machine} (load {load} at the
end: times are those of a shared machine). A voxel is the geometric mean of the three spacings, tau
a triangle's shortest over its longest edge. Figures outside their limit are **bold**.

Asked of all: no defect of any kind and the segmentation's topology, for the coordinates as they are
in the file; the same bytes with 1, 2 and 4 threads and, where there is a device, on OpenCL; and the
limits below.

"""


def rounded(value: Any) -> Any:
    """Floats to five significant digits, all through."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    return value


def compact_json(content: dict[str, Any]) -> str:
    """One row a line."""
    head = json.dumps(rounded({k: v for k, v in content.items() if k != "rows"}), indent=1)
    rows = ",\n  ".join(json.dumps(rounded(row)) for row in content["rows"])
    return f'{head[:-2]},\n "rows": [\n  {rows}\n ]\n}}\n'


def bold(text: Any, wrong: Any) -> str:
    return f"**{text}**" if wrong else str(text)


def triple(topology: dict[str, int]) -> str:
    return f"{topology['pieces']} / {topology['handles']} / {topology['cavities']}"


def table(head: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    head = list(head)
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n\n"


def given_up(row: Row) -> bool:
    """Whether the base surface came out where the adaptive one was asked for."""
    return row.get("mesh", {}).get("base_share", 0) == 1


def name_of(surface: str, row: Row) -> str:
    return row["label"] + (" (base surface)" if surface == "adaptive" and given_up(row) else "")


def defect_count(check: dict[str, Any]) -> int:
    names = (
        "open_edges",
        "nonmanifold_edges",
        "misoriented_edges",
        "nonmanifold_vertices",
        "isolated_vertices",
        "nonfinite_vertices",
        "inverted_shells",
        "mismatched_pieces",
    )
    return sum(check[name] for name in names)


def proof_cells(row: Row) -> list[str]:
    check = row["check"]
    counts = (check["intersecting_pairs"], check["degenerate_triangles"], defect_count(check))
    return [
        f"{check['triangles']:,}",
        triple(check["wanted"]),
        bold(triple(check["topology"]), check["topology"] != check["wanted"]),
        *(bold(count, count) for count in counts),
        bold("yes" if row["same_bytes"] else "no", not row["same_bytes"]),
    ]


def cells(figures: list[Figure], row: Row) -> list[str]:
    return [figure.cell(row) for figure in figures]


def titles(figures: list[Figure]) -> list[str]:
    return [figure.title for figure in figures]


def shape_table(surface: str, rows: list[Row]) -> str:
    if surface == "adaptive":
        return table(
            ["input", "median radius, voxels", *titles(SHAPES), "hard share, %", "attempts"],
            (
                [
                    name_of(surface, row),
                    f"{row['median_radius']:.2f}" if row.get("median_radius") else "-",
                    *cells(SHAPES, row),
                    f"{100 * row['mesh']['hard_share']:.0f}",
                    row["mesh"]["attempts"],
                ]
                for row in rows
            ),
        )
    return table(
        [
            "input",
            "edge ratio, mean",
            "least angle, mean",
            "least angle, least",
            "size ratio, mean",
        ],
        (
            [
                row["label"],
                f"{row['quality']['edge_ratio']['mean']:.2f}",
                f"{row['quality']['least_angle']['mean']:.1f}",
                f"{row['quality']['least_angle']['minimum']:.2f}",
                f"{row['quality']['size_ratio']['mean']:.2f}",
            ]
            for row in rows
        ),
    )


def exact_cells(row: Row) -> list[str]:
    exact = row["exact"]
    error = f"{100 * exact['volume_error']:+.2f} %"
    return [
        *cells(EXACT_MEANS, row),
        *(f"{exact[way]['largest_mm']:.3f}" for way in ("to", "back")),
        bold(error, EXACT_VOLUME.outside(row)),
        "yes" if row["accurate"] else "no",
    ]


def time_table(surface: str, rows: list[Row]) -> str:
    stages = list(dict.fromkeys(name for row in rows for name in row["stages"]))
    memory = [f"{row['peak'] / 1e6:.0f}" for row in rows]
    if surface == "base":
        memory = [MEMORY["base"].cell(row) for row in rows]
    ratio = [MEMORY["adaptive"]] if surface == "adaptive" else []
    return table(
        ["input", "whole process", "processor", *stages, "peak, MB", *titles(ratio)],
        (
            [
                row["label"],
                f"{row['wall']:.2f}",
                f"{row['cpu']:.2f}",
                *(f"{row['stages'].get(name, 0):.2f}" for name in stages),
                peak,
                *cells(ratio, row),
            ]
            for row, peak in zip(rows, memory)
        ),
    )


def named_table(
    surface: str, head: list[str], rows: list[Row], cells_of: Callable[[Row], list[str]]
) -> str:
    return table(["input", *head], ([name_of(surface, row), *cells_of(row)] for row in rows))


def section(surface: str, title: str, rows: list[Row]) -> str:
    """The tables of one kind of input."""
    proof = [
        "triangles",
        "pieces / handles / cavities wanted",
        "got",
        "intersecting pairs",
        "degenerate triangles",
        "other defects",
        "same bytes",
    ]
    text = f"## {title}\n\n" + named_table(surface, proof, rows, proof_cells)
    text += named_table(
        surface,
        [*titles(DISTANCES), "limit, mm"],
        rows,
        lambda row: [*cells(DISTANCES, row), f"{largest_limit(row):.3f}"],
    )
    text += shape_table(surface, rows)
    exact = [row for row in rows if "exact" in row]
    if exact:
        head = [*titles(EXACT_MEANS), "largest to, mm", "largest back, mm", "volume", "limits hold"]
        text += "To the exact (or the given reference) surface:\n\n"
        text += named_table(surface, head, exact, exact_cells)
    if title != "Random trees":
        text += "Two threads, seconds; all but the processor time are wall clock:\n\n"
        text += time_table(surface, rows)
    return text


def verdict(surface: str, rows: list[Row]) -> str:
    wrong = [row for row in rows if row["outside"]]
    if not wrong:
        return f"All {len(rows)} inputs are within all limits.\n\n"
    lines = [f"- **{name_of(surface, row)}**: {'; '.join(row['outside'])}" for row in wrong]
    return (
        f"{len(rows) - len(wrong)} of {len(rows)} inputs are within all limits; outside:\n\n"
        + "\n".join(lines)
        + "\n\n"
    )


def limits(surface: str, rows: list[Row]) -> str:
    """Each limit: on how many inputs it is judged and missed, and the worst of them."""
    lines = []
    for figure in figures_of(surface):
        judged = [row for row in rows if figure.excess(row) is not None]
        if not judged:
            continue
        worst = max(judged, key=figure.excess)
        missed = sum(figure.outside(row) for row in judged)
        lines.append(
            [
                figure.name,
                ("at most " if figure.sign > 0 else "at least ") + figure.words,
                len(judged),
                bold(missed, missed),
                f"{figure.cell(worst)} ({worst['label']})",
            ]
        )
    return table(["figure", "limit", "inputs judged", "outside", "worst"], lines)


def markdown(content: dict[str, Any]) -> str:
    surface, rows = content["surface"], content["rows"]
    measured = [row for row in rows if "check" in row]
    text = INTRODUCTION.format(**content) + limits(surface, measured) + verdict(surface, rows)
    for kind, title in KINDS:
        chosen = [row for row in measured if row["kind"] == kind]
        if chosen:
            text += section(surface, title, chosen)
    return text.rstrip("\n") + "\n"

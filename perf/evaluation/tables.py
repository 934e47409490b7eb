"""The figures as tables, for Markdown and HTML alike."""

import html
from dataclasses import dataclass, field
from typing import Any, Callable

from .goals import better_than_ours, goals_of, spread

Row = dict[str, Any]
Content = dict[str, Any]


@dataclass
class Table:
    head: list[str]
    rows: list[list[str]]


@dataclass
class Section:
    """A title, lines of text, tables, lists and pictures (file names) in that order."""

    title: str
    level: int = 2
    text: list[str] = field(default_factory=list)
    table: Table | None = None
    items: list[str] = field(default_factory=list)
    pictures: list[tuple[str, str]] = field(default_factory=list)  # (file, caption)


def number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:,.{digits}f}"


def best_marked(values: list[float | None], digits: int, sign: int) -> list[str]:
    """Cells, the best in bold; sign 1: the least, -1: the largest, 0: none is better."""
    cells = [number(value, digits) for value in values]
    known = [sign * value for value in values if value is not None]
    if sign == 0 or len(known) < 2:
        return cells
    return [
        f"**{cell}**" if value is not None and sign * value == min(known) else cell
        for cell, value in zip(cells, values)
    ]


@dataclass(frozen=True)
class Column:
    title: str
    value: Callable[[Row], float | None]
    digits: int = 0
    sign: int = 1
    """1: less is better, -1: more, 0: neither."""


def way_columns(key: str) -> list[Column]:
    def entry(way: str, name: str) -> Callable[[Row], float | None]:
        return lambda row: row[key][way][name] if key in row else None

    columns = []
    for way, title in (("to", "to"), ("back", "back")):
        for name, word in (("mean", "mean"), ("maximum", "largest"), ("rms", "RMS")):
            for unit, short in (("mm", "mm"), ("voxels", "voxels")):
                columns.append(Column(f"{title}, {word}, {short}", entry(way, f"{name}_{unit}"), 3))
    return columns


def quality(*path: str) -> Callable[[Row], float]:
    def value(row: Row) -> float:
        found = row["quality"]
        for name in path:
            found = found[name]
        return found

    return value


SIZE = [
    Column("vertices", lambda r: r["check"]["vertices"]),
    Column("triangles", lambda r: r["check"]["triangles"]),
    Column("wall clock, s", lambda r: r["wall"], 2),
    Column("processor, s", lambda r: r["cpu"], 2),
    Column("peak memory, MB", lambda r: r["peak"] / 1e6),
]
SHAPE = [
    Column("edge ratio, mean", quality("edge_ratio", "mean"), 2, -1),
    Column("sd", quality("edge_ratio", "deviation"), 2),
    Column("0.8 and above, %", lambda r: 100 * r["quality"]["edge_ratio_above_08"], 1, -1),
    Column("below 0.3, %", lambda r: 100 * r["quality"]["edge_ratio_below_03"], 2),
    Column("below 0.1, %", lambda r: 100 * r["quality"]["edge_ratio_below_01"], 2),
    Column("least angle, mean", quality("least_angle", "mean"), 1, -1),
    Column("5th percentile", quality("least_angle", "percentile_5"), 1, -1),
    Column("least", quality("least_angle", "minimum"), 1, -1),
    Column("edges below 60 degrees", quality("sharp_edges")),
    Column("size ratio, mean", quality("size_ratio", "mean"), 2),
    Column("95th percentile", quality("size_ratio", "percentile_95"), 2),
]
SMOOTH = [
    Column("RMS curvature, mean, 1/mm", lambda r: r["rms_curvature"]["mean"], 2, 0),
    Column("5th percentile", lambda r: r["rms_curvature"]["percentile_5"], 2, 0),
    Column("median", lambda r: r["rms_curvature"]["median"], 2, 0),
    Column("95th percentile", lambda r: r["rms_curvature"]["percentile_95"], 2, 0),
    Column("spread, 95th - 5th", spread, 2),
]


def figures(rows: list[Row], columns: list[Column]) -> Table:
    """A row a method; those without figures say why."""
    done = [row for row in rows if row["status"] == "done"]
    cells = {row["method"]: [] for row in done}
    for column in columns:
        marked = best_marked([column.value(row) for row in done], column.digits, column.sign)
        for row, cell in zip(done, marked):
            cells[row["method"]].append(cell)
    lines = []
    for row in rows:
        found = cells.get(row["method"])
        lines.append(
            [
                row["method"],
                *(found or [f"{row['status']}: {row['reason']}"] + [""] * (len(columns) - 1)),
            ]
        )
    return Table(["method", *[column.title for column in columns]], lines)


def triple(topology: dict[str, int]) -> str:
    return f"{topology['pieces']} / {topology['handles']} / {topology['cavities']}"


def topology_table(rows: list[Row]) -> Table:
    lines = []
    for row in rows:
        if row["status"] != "done":
            lines.append([row["method"], f"{row['status']}: {row['reason']}", *[""] * 6])
            continue
        check = row["check"]
        right = check["topology"] == check["wanted"] and not check["mismatched_pieces"]
        names = (
            "open_edges",
            "nonmanifold_edges",
            "nonmanifold_vertices",
            "intersecting_pairs",
            "degenerate_triangles",
        )
        lines.append(
            [
                row["method"],
                triple(check["topology"]),
                "yes" if right else "no",
                *[f"{check[name]:,}" for name in names],
            ]
        )
    return Table(
        [
            "method",
            "pieces / handles / cavities",
            "as the segmentation",
            "open edges",
            "non-manifold edges",
            "non-manifold vertices",
            "self-intersecting pairs",
            "degenerate triangles",
        ],
        lines,
    )


def input_table(content: Content) -> Table:
    lines = []
    for given in content["inputs"]:
        lines.append(
            [
                given["name"],
                " x ".join(str(n) for n in given["size"]),
                " x ".join(f"{s:.4g}" for s in given["spacing"]),
                f"{given['object_voxels']:,}",
                triple(given["topology"]),
                number(given["median_radius"], 2),
                given["exact"],
            ]
        )
    return Table(
        [
            "data set",
            "voxels",
            "voxel size, mm",
            "voxels of the vessel",
            "pieces / handles / cavities",
            "median inscribed radius, voxels",
            "exact surface",
        ],
        lines,
    )


def stage_text(rows: list[Row]) -> list[str]:
    lines = []
    for row in rows:
        if row["status"] == "done" and len(row["stages"]) > 1:
            held = row.get("held", {})
            parts = ", ".join(
                f"{name} {seconds:.2f}"
                + (f" ({held[name] / 1e6:.0f} MB held)" if held.get(name) else "")
                for name, seconds in row["stages"].items()
            )
            lines.append(f"{row['method']}, seconds by stage: {parts}.")
    return lines


def exact_curvature_text(given: Content) -> list[str]:
    """What a method should show, no more and no less."""
    if "exact_surface" not in given:
        return []
    exact = given["exact_surface"]["rms_curvature"]
    names = ("mean", "percentile_5", "median", "percentile_95")
    mean, low, median, high = (f"{exact[name]:.2f}" for name in names)
    return [
        f"The exact surface's: mean {mean}, 5th percentile {low}, median {median}, 95th percentile "
        f"{high}, spread {spread(given['exact_surface']):.2f} /mm."
    ]


def exact_distance_text(given: Content) -> list[str]:
    if "exact_surface" not in given:
        return []
    to, back = (given["exact_surface"]["distance"][w]["mean_voxels"] for w in ("to", "back"))
    return [
        f"The exact surface itself: mean {to:.3f} voxels to marching cubes and {back:.3f} back. "
        "What is nearer follows the voxels' steps more than the vessel."
    ]


def judgement(given: Content) -> Section:
    rows = {row["method"]: row for row in given["methods"] if row["status"] == "done"}
    section = Section("What is asked of ours", 3)
    if "ours" not in rows:
        section.text = ["Ours has no figures."]
        return section
    section.items = [
        ("met: " if goal.met else "**not met**: ") + goal.text
        for goal in goals_of(rows, given["median_radius"], given.get("exact_surface"))
    ]
    better = better_than_ours(rows)
    section.items += [
        f"better than ours in {title}: {', '.join(names)}" for title, names in better.items()
    ]
    return section


def input_sections(given: Content, pictures: dict[str, str]) -> list[Section]:
    """All of one input; `pictures` are file names by kind."""
    rows = given["methods"]
    shown = {
        kind: [(pictures[kind], caption)] if kind in pictures else []
        for kind, caption in (
            ("curvature", "RMS curvature, 1/mm, the same scale for every method"),
            (
                "histograms",
                "RMS curvature over the area, edge ratio and least angle over triangles",
            ),
            ("curvature_close", "The same, round a branching"),
            ("close", "The triangles there"),
        )
    }
    sections = [
        Section(given["name"]),
        judgement(given),
        Section("Size and cost", 3, stage_text(rows), figures(rows, SIZE)),
        Section(
            "Distance to marching cubes",
            3,
            exact_distance_text(given) + given.get("independent", []),
            figures(rows, way_columns("distance")),
        ),
    ]
    if any("exact" in row for row in rows):
        sections.append(
            Section("Distance to the exact surface", 3, table=figures(rows, way_columns("exact")))
        )
    sections += [
        Section(
            "Smoothness",
            3,
            exact_curvature_text(given),
            figures(rows, SMOOTH),
            pictures=shown["curvature"] + shown["curvature_close"] + shown["histograms"],
        ),
        Section("Triangle quality", 3, table=figures(rows, SHAPE), pictures=shown["close"]),
        Section(
            "Topology",
            3,
            [f"The segmentation's: {triple(given['topology'])}."],
            topology_table(rows),
        ),
    ]
    return sections


def markdown_table(table: Table) -> str:
    lines = ["| " + " | ".join(table.head) + " |", "|" + "---|" * len(table.head)]
    lines += ["| " + " | ".join(row) + " |" for row in table.rows]
    return "\n".join(lines) + "\n"


def markdown(sections: list[Section]) -> str:
    parts = []
    for section in sections:
        parts.append("#" * section.level + f" {section.title}\n")
        parts += [line + "\n" for line in section.text]
        if section.table:
            parts.append(markdown_table(section.table))
        if section.items:
            parts.append("\n".join(f"- {item}" for item in section.items) + "\n")
        parts += [f"![{caption}]({file})\n" for file, caption in section.pictures]
    return "\n".join(parts)


def to_html(text: str) -> str:
    """Escaped; **bold** and `code` kept."""
    pieces = html.escape(text).split("**")
    text = "".join(f"<b>{p}</b>" if i % 2 else p for i, p in enumerate(pieces))
    pieces = text.split("`")
    return "".join(f"<code>{p}</code>" if i % 2 else p for i, p in enumerate(pieces))


def html_table(table: Table) -> str:
    head = "".join(f"<th>{to_html(cell)}</th>" for cell in table.head)
    rows = "".join(
        "<tr>" + "".join(f"<td>{to_html(cell)}</td>" for cell in row) + "</tr>\n"
        for row in table.rows
    )
    return f'<div class="wide"><table><tr>{head}</tr>\n{rows}</table></div>\n'


def html_sections(sections: list[Section], source: Callable[[str], str]) -> str:
    """`source` gives the address of a picture's file."""
    parts = []
    for section in sections:
        parts.append(f"<h{section.level}>{to_html(section.title)}</h{section.level}>\n")
        parts += [f"<p>{to_html(line)}</p>\n" for line in section.text]
        if section.table:
            parts.append(html_table(section.table))
        if section.items:
            parts.append(
                "<ul>" + "".join(f"<li>{to_html(i)}</li>\n" for i in section.items) + "</ul>\n"
            )
        parts += [
            f'<figure><img src="{source(file)}" alt="{to_html(caption)}"><figcaption>'
            f"{to_html(caption)}</figcaption></figure>\n"
            for file, caption in section.pictures
        ]
    return "".join(parts)

"""The figures of perf/table.py as Markdown and JSON."""

import json

KINDS = (("small", "Phantoms"), ("accuracy", "Phantoms of other spacings and radii"),
         ("large", "Large trees"), ("data", "Real volumes"), ("tree", "Random trees"))

INTRODUCTION = """\
# Figures of the base surface

Written by `perf/table.py` with {version} on a {machine} (load {load} at the end: times are those of
a shared machine). A voxel is the geometric mean of the three spacings. Figures outside their limit
are **bold**.

Limits: no defect of any kind and the segmentation's topology, for the coordinates as they are in
the file; the same bytes with 1, 2 and 4 threads; mean distance to the marching-cubes surface of the
segmentation 0.17 voxel on real volumes and 0.27 on phantoms, both ways; largest distance under the
larger of the smallest spacing and 0.55 of the largest; where the exact surface is known and no
radius is below 2.5 voxels, mean distance to it 0.12 voxel and volume within 2 %; peak memory 1 GB
for `cerebral`, 3 GB for `airways`.

"""


def rounded(value):
    """Floats to five significant digits, all through."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    return value


def compact_json(content):
    """One row a line."""
    head = json.dumps(rounded({k: v for k, v in content.items() if k != "rows"}), indent=1)
    rows = ",\n  ".join(json.dumps(rounded(row)) for row in content["rows"])
    return f"{head[:-2]},\n \"rows\": [\n  {rows}\n ]\n}}\n"


def bold(text, wrong):
    return f"**{text}**" if wrong else str(text)


def triple(topology):
    return f"{topology['pieces']} / {topology['handles']} / {topology['cavities']}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n\n"


def defect_count(check):
    names = ("open_edges", "nonmanifold_edges", "misoriented_edges", "nonmanifold_vertices",
             "isolated_vertices", "nonfinite_vertices", "inverted_shells", "mismatched_pieces")
    return sum(check[name] for name in names)


def proof_row(row):
    check = row["check"]
    return (row["label"], f"{check['triangles']:,}", triple(check["wanted"]),
            bold(triple(check["topology"]), check["topology"] != check["wanted"]),
            *(bold(count, count) for count in (check["intersecting_pairs"],
                                               check["degenerate_triangles"],
                                               defect_count(check))),
            bold("yes" if row["same_bytes"] else "no", not row["same_bytes"]))


def distance_row(row):
    limit = 0.17 if row["kind"] == "data" else 0.27
    ways = [row["distance"][way] for way in ("to", "back")]
    cells = [bold(f"{d['mean_voxels']:.3f}", d["mean_voxels"] > limit) for d in ways]
    cells += [bold(f"{d['largest_mm']:.3f}", d["largest_mm"] >= row["limit_mm"]) for d in ways]
    quality = row["quality"]
    return (row["label"], *cells, f"{row['limit_mm']:.3f}", f"{quality['edge_ratio']['mean']:.2f}",
            f"{quality['least_angle']['mean']:.1f}", f"{quality['least_angle']['minimum']:.2f}",
            f"{quality['size_ratio']['mean']:.2f}")


def exact_row(row):
    exact, strict = row["exact"], row["accurate"]
    means = [exact[way]["mean_voxels"] for way in ("to", "back")]
    error = exact["volume_error"]
    return (row["label"], *(bold(f"{mean:.3f}", strict and mean > 0.12) for mean in means),
            *(f"{exact[way]['largest_mm']:.3f}" for way in ("to", "back")),
            bold(f"{100 * error:+.2f} %", strict and abs(error) > 0.02), "yes" if strict else "no")


def time_row(row, stages):
    return (row["label"], f"{row['wall']:.2f}", f"{row['cpu']:.2f}",
            *(f"{row['stages'].get(name, 0):.2f}" for name in stages),
            f"{row['peak'] / 1e6:.0f}")


def section(title, rows):
    """The tables of one kind of input."""
    text = f"## {title}\n\n"
    text += table(("input", "triangles", "pieces / handles / cavities wanted", "got",
                   "intersecting pairs", "degenerate triangles", "other defects",
                   "same bytes"), map(proof_row, rows))
    text += table(("input", "mean to, voxel", "mean back, voxel", "largest to, mm",
                   "largest back, mm", "limit, mm", "edge ratio, mean", "least angle, mean",
                   "least angle, least", "size ratio, mean"), map(distance_row, rows))
    exact = [row for row in rows if "exact" in row]
    if exact:
        text += "To the exact (or the given reference) surface:\n\n"
        text += table(("input", "mean to, voxel", "mean back, voxel", "largest to, mm",
                       "largest back, mm", "volume", "limits hold"), map(exact_row, exact))
    if title != "Random trees":
        stages = list(rows[0]["stages"])
        text += "Two threads, seconds; all but the processor time are wall clock:\n\n"
        text += table(("input", "whole process", "processor", *stages, "peak, MB"),
                      (time_row(row, stages) for row in rows))
    return text


def verdict(rows):
    wrong = [row for row in rows if row["outside"]]
    if not wrong:
        return f"All {len(rows)} inputs are within all limits.\n\n"
    lines = [f"- **{row['label']}**: {'; '.join(row['outside'])}" for row in wrong]
    return (f"{len(rows) - len(wrong)} of {len(rows)} inputs are within all limits; outside:\n\n" +
            "\n".join(lines) + "\n\n")


def worst(rows):
    """The largest figures over all inputs."""
    measured = [row for row in rows if "check" in row]
    if not measured:
        return ""
    of_limit = [max(row["distance"][w]["largest_mm"] for w in ("to", "back")) / row["limit_mm"]
                for row in measured]
    means = [max(row["distance"][w]["mean_voxels"] for w in ("to", "back")) for row in measured]
    at, mean_at = of_limit.index(max(of_limit)), means.index(max(means))
    return (f"Worst: largest distance {100 * max(of_limit):.0f} % of its limit "
            f"({measured[at]['label']}); mean distance {max(means):.3f} voxel "
            f"({measured[mean_at]['label']}).\n\n")


def markdown(content):
    rows = content["rows"]
    text = INTRODUCTION.format(**content) + verdict(rows) + worst(rows)
    for kind, title in KINDS:
        measured = [row for row in rows if row["kind"] == kind and "check" in row]
        if measured:
            text += section(title, measured)
    return text.rstrip("\n") + "\n"

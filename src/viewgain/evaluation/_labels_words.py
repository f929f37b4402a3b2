"""The table of labels in words."""

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._labels import LabelRow, LabelTable
from viewgain.evaluation._markdown import markdown_table

_OUTCOMES = ("mean \\|volume error\\|, %", "near zero error, %", "no estimate, %")


def labels_markdown(table: LabelTable) -> str:
    """Return the table as Markdown: what each label chooses, what comes of it, and how that differs from the first one."""
    by_box = [(row.name, *map(str, row.best)) for row in table.rows if row.best is not None]
    differences = [(row.name, *_cells(row.difference, sign="+")) for row in table.rows if row.difference is not None]
    weighed = [(row.name, *(f"{value:.3f}" for value in (*row.by_position, row.widest))) for row in table.chosen_by]
    return "\n".join([
        "## Labels: which position they choose, and what it is worth", "",
        f"Data {table.data}, rig {table.rig}: {table.scans:,} scans of {len(table.boxes)} boxes, measured by {table.estimator}. A"
        " scan errs by min(\\|V / V* − 1\\|, 1), and by 1 without an estimate; near zero is the middle bin of the histogram. The"
        " scans are those that labels are counted from. Every box counts alike; 95 % intervals by box, of few boxes too narrow."
        " Moved: boxes, and scans of them, to which the label gives another position than the first label does.", "",
        *markdown_table(
            ("label", f"boxes by position, 0 to {table.positions - 1}", "moved boxes", "moved scans", *_OUTCOMES),
            [(row.name, *_places(row, table.positions), *_cells(row.outcomes)) for row in table.rows],
        ), "",
        "Differences from the first label on the same boxes, in points:", "",
        *markdown_table(("label", "mean \\|volume error\\|", "near zero error", "no estimate"), differences), "",
        "What is weighed, without weights: mean over boxes, and the largest difference between two positions of one box:", "",
        *markdown_table(("", *(f"position {place}" for place in range(table.positions)), "largest difference"), weighed), "",
        "Position by box:", "",
        *markdown_table(("label", *map(str, table.boxes)), by_box),
    ]) + "\n"  # fmt: skip


def _places(row: LabelRow, positions: int) -> tuple[str, str, str]:
    if row.best is None:
        return "drawn", "", ""
    return ", ".join(str(row.best.count(place)) for place in range(positions)), str(row.other_boxes), f"{row.other_scans:,}"


def _cells(shares: Shares, sign: str = "") -> list[str]:
    return [
        f"{100 * mean:{sign}.1f} ({100 * low:{sign}.1f} to {100 * high:{sign}.1f})"
        for mean, low, high in zip(shares.mean, shares.low, shares.high, strict=True)
    ]

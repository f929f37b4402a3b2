"""A table for people."""

from collections.abc import Sequence

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._judged import SPLITS
from viewgain.evaluation._table1 import CONSTANT, Table1
from viewgain.gain import POSITION_LIMITS

COLUMNS = ("exact position", *(f"within {limit:g}" for limit in POSITION_LIMITS[1:]))
"""Names of the shares."""


def to_markdown(table: Table1) -> str:
    """Return the table as Markdown: what it is about, shares in per cent with 95 % intervals, paired differences in points."""
    return "\n".join([*_heading(table), "", *_shares(table), *_differences(table)]) + "\n"


def _heading(table: Table1) -> list[str]:
    constant = (
        f"The constant answer is {table.offset} views on from the present one, best most often on {table.learned_samples:,}"
        " training samples."
        if table.offset is not None
        else f"No {CONSTANT}: the data set has no training samples to choose it on."
    )
    return [
        f"## Table 1, {SPLITS.get(table.split, table.split)}",
        "",
        f"Data {table.data}, {table.samples:,} samples of {table.objects:,} objects; rig {table.rig}, {table.views} views, one"
        f" step; {table.frame} frame; a view is worth its {table.target}.",
        "Share of the samples in per cent, with the 95 % interval by objects drawn anew. A view worth as much as the best is the"
        " best. Visited views cannot be chosen. Time: median CPU time of one cloud, one thread.",
        constant,
    ]


def _shares(table: Table1) -> list[str]:
    rows = [(row.name, *_cells(row.shares), "" if row.milliseconds is None else f"{row.milliseconds:.1f}") for row in table.rows]
    return _table(("", *COLUMNS, "ms"), rows)


def _differences(table: Table1) -> list[str]:
    if not table.differences:
        return []
    rows = [(f"{each.first} − {each.second}", *_cells(each.shares, sign="+")) for each in table.differences]
    return ["", "Differences on the same samples, in points:", "", *_table(("", *COLUMNS), rows)]


def _cells(shares: Shares, sign: str = "") -> list[str]:
    return [
        f"{100 * mean:{sign}.2f} ({100 * low:{sign}.1f} to {100 * high:{sign}.1f})"
        for mean, low, high in zip(shares.mean, shares.low, shares.high, strict=True)
    ]


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return ["| " + " | ".join(row) + " |" for row in (header, ["---"] * len(header), *rows)]

"""Tables for people."""

from collections.abc import Sequence

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._records import CONSTANT, Table1
from viewgain.gain import POSITION_LIMITS

COLUMNS = ("exact position", *(f"within {limit:g}" for limit in POSITION_LIMITS[1:]))
"""Names of the shares."""


def to_markdown(table: Table1) -> str:
    """Return the table as Markdown: what it is about, shares in per cent with 95 % intervals, paired differences in points."""
    return "\n".join([*_heading(table), "", *_shares(table), *_differences(table)]) + "\n"


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    return ["| " + " | ".join(row) + " |" for row in (header, ["---"] * len(header), *rows)]


def _heading(table: Table1) -> list[str]:
    skipped = f"; {len(table.skipped)} skipped" if table.skipped else ""
    return [
        f"## Table 1, {table.frame} frame: {table.title}",
        "",
        f"Data: {table.data}; {table.samples:,} samples of {table.objects:,} objects{skipped}; rig {table.rig}, {table.views}"
        f" views, one step; {table.frame} frame; a view is worth its {table.target}.",
        "Share of the samples in per cent, with the 95 % interval by objects drawn anew. A view worth as much as the best is the"
        " best. Visited views cannot be chosen. Time: median CPU time of one cloud, one thread.",
        _constant(table),
    ]


def _constant(table: Table1) -> str:
    if table.constant_chosen is None:
        return f"No {CONSTANT}: there is neither a training sample nor a second object to choose it on."
    if table.constant_chosen == "training":
        return (
            f"The constant answer is {table.offsets[0]} views on from the present one, best most often on"
            f" {table.constant_samples:,} training samples."
        )
    return (
        f"The constant answer is two-fold: on each half of the objects the one that is best most often on the other half"
        f" ({table.offsets[1]} and {table.offsets[0]} views on from the present one), so it knows objects of these very"
        " categories."
    )


def _shares(table: Table1) -> list[str]:
    rows = [(row.name, *_cells(row.shares), "" if row.milliseconds is None else f"{row.milliseconds:.1f}") for row in table.rows]
    return markdown_table(("", *COLUMNS, "ms"), rows)


def _differences(table: Table1) -> list[str]:
    points, shares, closed = [], [], []
    for each in table.differences:
        points.append((f"{each.first} − {each.second}", *_cells(each.shares, sign="+")))
        if each.share is not None:
            shares.append((f"{each.first} / {each.second}", *_cells(each.share)))
        if each.closed is not None:
            closed.append((each.first, *_cells(each.closed)))
    return [
        *_titled("Differences on the same samples, in points:", points),
        *_titled("The same as a share, in per cent:", shares),
        *_titled("As a share of the figures on seen categories, in per cent:", [(e.name, *_cells(e.shares)) for e in table.kept]),
        *_titled("Share of the gap from the constant answer to 100 % that is closed, in per cent:", closed),
    ]


def _titled(title: str, rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a table of shares under its title; nothing without rows."""
    return ["", title, "", *markdown_table(("", *COLUMNS), rows)] if rows else []


def _cells(shares: Shares, sign: str = "") -> list[str]:
    return [
        f"{100 * mean:{sign}.2f} ({100 * low:{sign}.1f} to {100 * high:{sign}.1f})"
        for mean, low, high in zip(shares.mean, shares.low, shares.high, strict=True)
    ]

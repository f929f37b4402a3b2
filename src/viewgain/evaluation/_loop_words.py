"""The table of the closed loop for people."""

from collections.abc import Sequence

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._loop_table import LoopRow, LoopTable
from viewgain.evaluation._markdown import markdown_table
from viewgain.evaluation._quantity import Quantity

_HEADER = (
    "",
    "views until it stops",
    "to the oracle's",
    "never stopped, %",
    "within tolerance when stopped, %",
    "views until within tolerance",
    "to the oracle's",
    "never within, %",
    "final error, median, %",
    "mean, %",
    "undecided",
)
_LESS = ("less than random", "views until it stops", "views until within tolerance", "final error, points")


def loop_markdown(table: LoopTable) -> str:
    """Return the tables as Markdown: what was asked, the policies, the paired differences, errors by number of views."""
    parts = [_heading(table), _text(_HEADER, [_cells(row) for row in table.rows])]
    less = [(row, row.less_random) for row in table.rows if row.name != "random" and row.less_random is not None]
    if less:
        parts.append(_text(_LESS, [
            (row.name, _of(each, 0), _of(each, 1), _of(each, 2, 100.0)) for row, each in less
        ]))  # fmt: skip
    played = [(row, row.errors) for row in table.rows if row.errors is not None]
    if played:
        header = ("mean error after views, %", *(str(1 + k) for k in range(table.settings.most_views)))
        parts.append(_text(header, [
            (row.name, *(_of(each, k, 100.0) for k in range(table.settings.most_views))) for row, each in played
        ]))  # fmt: skip
    return "\n\n".join(parts) + "\n"


def _cells(row: LoopRow) -> tuple[str, ...]:
    return (
        row.name,
        _of(row.means, 0),
        _ratio(row.to_oracle),
        _of(row.means, 1, 100.0, 1),
        _of(row.within_when_stopped, 0, 100.0, 1) if row.within_when_stopped else "",
        _of(row.means, 2),
        _ratio(row.to_oracle_within),
        _of(row.means, 3, 100.0, 1),
        _of(row.median_error, 0, 100.0),
        _of(row.means, 4, 100.0),
        str(row.undecided),
    )


def _heading(table: LoopTable) -> str:
    asked = table.settings
    boxes = asked.boxes
    return (
        f"## Closed loop: {table.boxes} fresh boxes of seed {boxes.seed}, rig {boxes.rig}, camera {boxes.camera}\n\n"
        f"Sides {boxes.side[0]:g} to {boxes.side[1]:g} m, random yaw. The rule stops when the planner gives the relative volume"
        f" error a chance of over {100 * asked.confidence:g} % to be under {100 * asked.tolerance:g} %; at most"
        f" {asked.most_views} views, which is what one that never got there counts with. The same first scan for all, and scan k"
        " of a position is the same whoever takes it. An error is |V / V* − 1|, at most 100 %, and 100 % without a volume. 95 %"
        " intervals, by box."
    )


def _text(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(markdown_table(header, rows))


def _of(shares: Shares, column: int, times: float = 1.0, digits: int = 2) -> str:
    mean, low, high = (times * each[column] for each in (shares.mean, shares.low, shares.high))
    return f"{mean:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _ratio(value: Quantity | None) -> str:
    return "" if value is None else f"{value.value:.2f} ({value.low:.2f} to {value.high:.2f})"

"""The table of planners for objects of any shape for people."""

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._markdown import markdown_table
from viewgain.evaluation._shape_case import VOLUMES
from viewgain.evaluation._shape_table import ShapeRow, ShapeTable

_NAMED = 12
"""So many kinds are named, of more only their number."""
_EACH = ("error, %", "gap closed, %", "best position, %")


def shape_markdown(table: ShapeTable) -> str:
    """Return the table as Markdown: what was asked, then rows with 95 % intervals by object."""
    header = ("", *(f"{name}: {each}" for name in VOLUMES for each in _EACH), "undecided", "ms")
    return "\n".join([*_heading(table), "", *markdown_table(header, [_cells(row) for row in table.rows])]) + "\n"


def _cells(row: ShapeRow) -> tuple[str, ...]:
    figures = [
        cell
        for k in range(len(VOLUMES))
        for cell in (_share(row.error, k, 2), "" if row.closed is None else _share(row.closed, k, 0), _share(row.best, k))
    ]
    decides = row.milliseconds is not None
    return (row.name, *figures, str(row.undecided) if decides else "", f"{row.milliseconds:.0f}" if decides else "")


def _heading(table: ShapeTable) -> list[str]:
    asked = table.settings
    kinds = asked.kinds()
    of = "meshes" if asked.meshes is not None else "fresh procedural objects"
    named = ", ".join(kinds) if len(kinds) <= _NAMED else f"{len(kinds)} categories"
    two = [
        f"{name} {_share(table.first, k, 1)} alone, {_share(table.bias, k, 1)} on average with its sign after a second scan,"
        f" {table.counted[k]:.1f} of {table.reachable:.1f} positions count as best, ceiling {_share(table.ceiling, k)}"
        for k, name in enumerate(VOLUMES)
    ]
    return [
        f"## The second view of objects of any shape: {table.objects} {of} of seed {asked.seed}, rig {asked.rig}, camera"
        f" {asked.camera}",
        "",
        f"Kinds: {named}. Diagonal {asked.size[0]:g} to {asked.size[1]:g} m, random yaw, on a bare floor. A position is worth the"
        f" expected |relative error| of a volume from its scan and the first one together, over {asked.captures} scans; at most"
        " 100 %, and 100 % without an object. The hull and the smallest box that stands on the floor are of the points that"
        " neither scan looks through. One decision per object, from one scan of a random position, which cannot be chosen again."
        f" The oracle chooses by {asked.captures} other scans, for either volume by itself.",
        "Gap closed: from a uniform guess (0 %) to the oracle (100 %), with the 95 % interval by objects drawn anew. In per"
        f" cent: {'; '.join(two)}.",
    ]


def _share(shares: Shares, column: int, digits: int = 1) -> str:
    mean, low, high = (100 * each[column] for each in (shares.mean, shares.low, shares.high))
    return f"{mean:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"

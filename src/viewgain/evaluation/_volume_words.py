"""The table of volume planners for people."""

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._markdown import markdown_table
from viewgain.evaluation._quantity import Quantity
from viewgain.evaluation._risk import KEPT
from viewgain.evaluation._selective_words import selective_markdown
from viewgain.evaluation._volume_case import VolumeSettings
from viewgain.evaluation._volume_table import VolumeTable

_HEADER = ("", "best position, %", "of the ceiling", "within 2 points, %", "mean error, %", "to the oracle's", "undecided", "ms")


def volume_markdown(table: VolumeTable) -> str:
    """Return the table as Markdown: what was asked, ceiling, rows with 95 % intervals by box."""
    rows = [
        (
            row.name,
            _share(row.shares, 0),
            _ratio(row.of_ceiling),
            _share(row.shares, 1),
            _share(row.shares, 2, digits=2),
            _ratio(row.to_oracle),
            str(row.undecided) if row.milliseconds is not None else "",
            f"{row.milliseconds:.0f}" if row.milliseconds is not None else "",
        )
        for row in table.rows
    ]
    sure = {row.name: row.sure for row in table.rows if row.sure is not None}
    return "\n".join([*_heading(table), "", *markdown_table(_HEADER, rows), *_risks(table), *selective_markdown(sure)]) + "\n"


def _risks(table: VolumeTable) -> list[str]:
    """Return the risk-coverage table, where something decides."""
    rows = [(row.name, *(f"{100 * risk:.2f}" for risk in row.kept)) for row in table.rows if row.kept]
    if not rows:
        return []
    header = ("points of error above the best position, deciding on", *(f"{share:.0%} of boxes" for share in KEPT))
    order = "Left out first: boxes where a policy's best and next best position are nearest to each other by its own scores."
    return ["", *markdown_table(header, rows), "", order]


def _heading(table: VolumeTable) -> list[str]:
    asked = table.settings
    what = "fused with the present scan" if asked.fused else "alone"
    return [
        f"## Next best view for volume: {boxes_in_words(table)}, rig {asked.rig}, camera {asked.camera}",
        "",
        f"Sides {asked.side[0]:g} to {asked.side[1]:g} m, random yaw{off_centre_in_words(asked)}."
        f" A position is worth the expected |relative volume error| of a scan from it {what},"
        f" estimator {asked.estimator}, over {asked.captures} scans; a scan without an estimate"
        f" ({100 * table.missed:.1f} % of all) counts as 100 %. Positions within two standard errors of the least count as best:"
        f" {table.best:.1f} of {table.reachable:.1f} that can be reached; on {table.no_choice} boxes all of them do. One decision"
        " per box, from one scan of a random present position, in the camera frame. The oracle chooses by"
        f" {asked.captures} other scans.",
        f"Ceiling, by split halves of the scans: the best position of one half counts as best in the other in"
        f" {_share(table.ceiling, 0)} %; both halves name the same in {_share(table.ceiling, 1)} %.",
    ]


def boxes_in_words(table: VolumeTable) -> str:
    """Return which boxes were judged."""
    later = f" from number {table.first} on" if table.first else ""
    return f"{table.boxes:,} fresh boxes of seed {table.settings.seed}{later}"


def off_centre_in_words(asked: VolumeSettings) -> str:
    """Return where the rig stands if it is not around the box's centre, to go on a sentence with."""
    return f", the rig's middle {100 * asked.off_centre:g} cm per axis off the box's centre" if asked.off_centre else ""


def _share(shares: Shares, column: int, digits: int = 1) -> str:
    mean, low, high = (100 * each[column] for each in (shares.mean, shares.low, shares.high))
    return f"{mean:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _ratio(value: Quantity) -> str:
    return f"{value.value:.2f} ({value.low:.2f} to {value.high:.2f})"

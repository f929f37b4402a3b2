"""The table of the closed loop: how many views each policy needs, how exact it is then, and how honest the stop rule."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import DataError
from viewgain.evaluation._bootstrap import Shares, difference_by_object, median_by_object, ratio_by_object, shares_by_object
from viewgain.evaluation._loop_case import LoopSettings
from viewgain.evaluation._loop_play import LoopPlay
from viewgain.evaluation._loop_policies import FEWEST, RANDOM
from viewgain.evaluation._plain import finite
from viewgain.evaluation._quantity import Quantity
from viewgain.evaluation._ratios import ratio

LOOP_COLUMNS = ("views_to_stop", "never_stopped", "views_to_tolerance", "never_within_tolerance", "final_error")
"""What is averaged over boxes; a policy that never got there counts with the most views."""
COMPARED = ("views_to_stop", "views_to_tolerance", "final_error")
"""Those of them that are held against the random policy."""
_STREAM = 0x7634


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopRow:
    """One policy."""

    name: str
    """Who chose."""
    means: Shares
    """Of :data:`LOOP_COLUMNS`."""
    median_error: Shares
    """Median final error."""
    within_when_stopped: Shares | None
    """Share of boxes with a final error within the tolerance, of those on which the stop rule fired; None if it never did."""
    to_oracle: Quantity | None
    """Mean views until the rule fired, over the oracle's; None where the oracle was not asked."""
    to_oracle_within: Quantity | None
    """The same of the views until the true error was within the tolerance."""
    less_random: Shares | None
    """Means of :data:`COMPARED` less those of the random policy on the same boxes; None where that did not play."""
    errors: Shares | None
    """Mean error after 1, 2, ... views; None of the oracle."""
    undecided: int
    """Choices on which it had no opinion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopTable:
    """One table."""

    settings: LoopSettings
    """What was asked."""
    boxes: int
    """How many."""
    rows: tuple[LoopRow, ...]
    """Policies, in the order in which they are named."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON."""
        return {
            "columns": list(LOOP_COLUMNS),
            "compared": list(COMPARED),
            "settings": self.settings.to_dict(),
            "boxes": self.boxes,
            "rows": [finite(dataclasses.asdict(row)) for row in self.rows],
        }


def loop_table(settings: LoopSettings, boxes: Sequence[Mapping[str, LoopPlay]], policies: Sequence[str]) -> LoopTable:
    """Return the table of what came of some boxes.

    Every row draws the same boxes for its intervals, so a row depends on no other but those it is held against.

    Args:
        settings: What they answer.
        boxes: What came of each by policy, 2 boxes or more.
        policies: Names to show, in order.

    Raises:
        DataError: If there are fewer than two boxes.
    """
    if len(boxes) < 2:
        raise DataError(f"evaluate loop: got {len(boxes)} box, wanted 2 or more")
    values = {name: _values([plays[name] for plays in boxes], settings.most_views) for name in policies}
    rows = (
        _row(name, [plays[name] for plays in boxes], values[name], values.get(FEWEST), values.get(RANDOM), settings)
        for name in policies
    )
    return LoopTable(settings=settings, boxes=len(boxes), rows=tuple(rows))


def _row(
    name: str, plays: Sequence[LoopPlay], values: Array, oracle: Array | None, random: Array | None, settings: LoopSettings
) -> LoopRow:
    boxes = np.arange(len(plays))
    stopped = np.array([[play.stopped is not None] for play in plays])
    honest = stopped & (values[:, 4:] <= settings.tolerance)
    shown = [LOOP_COLUMNS.index(column) for column in COMPARED]
    ratios = [None if oracle is None else ratio(values[:, k], oracle[:, k], rng=_rng(settings)) for k in (0, 2)]
    less = None if random is None else difference_by_object(values[:, shown], random[:, shown], boxes, rng=_rng(settings))
    errors = None if name == FEWEST else shares_by_object([play.errors for play in plays], boxes, rng=_rng(settings))
    return LoopRow(
        name=name,
        means=shares_by_object(values, boxes, rng=_rng(settings)),
        median_error=median_by_object(values[:, 4], rng=_rng(settings)),
        within_when_stopped=ratio_by_object(honest, stopped, boxes, rng=_rng(settings)),
        to_oracle=ratios[0],
        to_oracle_within=ratios[1],
        less_random=less,
        errors=errors,
        undecided=sum(play.undecided for play in plays),
    )


def _values(plays: Sequence[LoopPlay], most: int) -> Array:
    """Return (B, 5) what is averaged."""
    rows = [(play.stopped or most, play.stopped is None, play.within or most, play.within is None, play.final) for play in plays]
    return np.array(rows, dtype=float)


def _rng(settings: LoopSettings) -> np.random.Generator:
    return np.random.default_rng([settings.boxes.seed, _STREAM])

"""What a table says, as records."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from viewgain.datasets import Frame, Skipped
from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._constant import Chosen
from viewgain.gain import POSITION_LIMITS

RESERVED = UNIFORM, RANDOM, CONSTANT, ORACLE = "uniform guess", "random", "constant answer", "oracle"
"""Names of the rows that no network made."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One way to choose."""

    name: str
    """What chooses."""
    shares: Shares
    """Of the samples, one per limit of ``viewgain.gain.POSITION_LIMITS``."""
    seeds: int = 1
    """How many networks it is the mean of."""
    within: str | None = None
    """Name of the mean over seeds that it is part of."""
    milliseconds: float | None = None
    """Median CPU time from a cloud to its scores, one thread; None where nothing is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Two ways to choose on the same samples; several seeds are averaged first."""

    first: str
    second: str
    shares: Shares
    """First minus second, paired by object."""
    share: Shares | None = None
    """Of two networks: the first as a share of the second."""
    closed: Shares | None = None
    """Of a network against the constant answer: share of the gap from there to 1 that it closes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Kept:
    """What of a network's figures on seen categories is left on others."""

    name: str
    shares: Shares
    """Figure here / figure there; the objects of both are drawn anew by themselves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table1:
    """One table."""

    data: str
    """Name of the data set's recipe."""
    split: str
    """Which part is judged."""
    title: str
    """The same in words."""
    rig: str
    views: int
    frame: Frame
    """Frame of the points."""
    target: str
    """Scores that say what a view is worth."""
    samples: int
    objects: int
    skipped: tuple[Skipped, ...]
    """What of the data set could not be made."""
    constant_chosen: Chosen | None
    """How the constant answer was chosen; None if there is none."""
    constant_samples: int
    """On how many samples."""
    offsets: tuple[int, ...]
    """The constant answer, views from the present one: one, or one for each half of the objects."""
    rows: tuple[Row, ...]
    """Networks first, means over their seeds, then floors and the oracle."""
    differences: tuple[Difference, ...]
    """Families against the constant answer, then against each other by :func:`viewgain.evaluation.compared`."""
    kept: tuple[Kept, ...] = ()
    """Of each family, where seen categories were judged as well."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON, the limits with it."""
        return {"limits": list(POSITION_LIMITS), **dataclasses.asdict(self)}

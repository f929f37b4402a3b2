"""The paper's Table 1: how often the best view is chosen, or one nearly as good; beside floors and with intervals."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets import Dataset, rig_of
from viewgain.errors import DataError
from viewgain.evaluation._bootstrap import Shares, difference_by_object, shares_by_object
from viewgain.evaluation._judged import Judged, judged_rows, learned_rows, read_judged
from viewgain.evaluation._scored import scored
from viewgain.gain import POSITION_LIMITS, choices, constant_offset, hits, shortfall, uniform_hits
from viewgain.inference import Scorer

RESERVED = UNIFORM, CONSTANT, ORACLE = "uniform guess", "constant answer", "oracle"
"""Names of the rows that no network made."""
_STREAM = 0x7431


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One way to choose."""

    name: str
    """What chooses."""
    shares: Shares
    """Of the samples, one per limit of ``viewgain.gain.POSITION_LIMITS``."""
    milliseconds: float | None = None
    """Median CPU time from a cloud to its scores, one thread; None where nothing is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Two ways to choose on the same samples."""

    first: str
    second: str
    shares: Shares
    """First minus second, paired by object."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table1:
    """One table."""

    data: str
    """Name of the data set's recipe."""
    split: str
    """Division whose test part is judged."""
    rig: str
    views: int
    frame: str
    """Frame of the points."""
    target: str
    """Scores that say what a view is worth."""
    samples: int
    objects: int
    learned_samples: int
    """Training samples that the constant answer was chosen on; without any there is no such row."""
    offset: int | None
    """The constant answer: views from the present one."""
    rows: tuple[Row, ...]
    """Networks first, then floors and the oracle."""
    differences: tuple[Difference, ...]
    """Each network against the constant answer, and against the first network."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON, the limits with it."""
        return {"limits": list(POSITION_LIMITS), **dataclasses.asdict(self)}


def table1(data: Dataset, scorers: Mapping[str, Scorer], *, split: str, target: str = "gain_published", seed: int = 0) -> Table1:
    """Return the table of one division of a data set.

    Everyone chooses among the views that were not visited yet; ties are counted as :func:`hits` says.

    Args:
        data: Clouds and what each view adds.
        scorers: Networks by name, each opened with one thread; none for the floors alone.
        split: ``same_category`` or ``other_category``.
        target: Which scores of the data set count.
        seed: Of the bootstrap.

    Raises:
        DataError: If nothing is to be judged there.
        ConfigError: If there is no such division or target, or a network is of another rig or frame.
    """
    rows = judged_rows(data, split)
    if len(rows) == 0:
        raise DataError(f"{data.folder}: got no sample to judge in division {split}; name another, or build more objects")
    judged, learned = read_judged(data, rows, target), read_judged(data, learned_rows(data), target)
    results, times = _network_hits(data, judged, scorers)
    offset = constant_offset(learned.gains, learned.free) if len(learned.rows) else None
    results |= _floor_hits(judged, offset)
    rng = np.random.default_rng([seed, _STREAM])
    return Table1(
        data=str(data.manifest.recipe["name"]),
        split=split,
        rig=rig_of(data.manifest),
        views=judged.gains.shape[1],
        frame=data.manifest.frame,
        target=target,
        samples=len(rows),
        objects=len(np.unique(judged.objects)),
        learned_samples=len(learned.rows),
        offset=offset,
        rows=_rows(results, times, judged.objects, rng),
        differences=_differences(results, list(scorers), judged.objects, rng),
    )


def _rows(
    results: Mapping[str, Array], times: Mapping[str, float], objects: NDArray[np.int64], rng: np.random.Generator
) -> tuple[Row, ...]:
    return tuple(
        Row(name=name, shares=shares_by_object(each, objects, rng=rng), milliseconds=times.get(name))
        for name, each in results.items()
    )


def _differences(
    results: Mapping[str, Array], networks: Sequence[str], objects: NDArray[np.int64], rng: np.random.Generator
) -> tuple[Difference, ...]:
    """Return each network against the constant answer, where there is one, then each further network against the first."""
    pairs = [(name, CONSTANT) for name in networks if CONSTANT in results] + [(name, networks[0]) for name in networks[1:]]
    return tuple(
        Difference(first=one, second=two, shares=difference_by_object(results[one], results[two], objects, rng=rng))
        for one, two in pairs
    )


def _network_hits(data: Dataset, judged: Judged, scorers: Mapping[str, Scorer]) -> tuple[dict[str, Array], dict[str, float]]:
    """Return (N, 5) hits and the median milliseconds of each network."""
    results, times = {}, {}
    for name, scorer in scorers.items():
        answer = scored(data, judged.rows, scorer)
        chosen = choices(answer.scores, judged.free)
        results[name] = hits(shortfall(judged.gains, chosen, judged.free)).astype(float)
        times[name] = float(np.median(answer.milliseconds))
    return results, times


def _floor_hits(judged: Judged, offset: int | None) -> dict[str, Array]:
    """Return (N, 5) hits, or chances of one, of what has learned nothing; and of the best view, which is what all are held to."""
    gains, free = judged.gains, judged.free
    floors = {UNIFORM: uniform_hits(gains, free)}
    if offset is not None:
        always = np.full(len(gains), offset)
        floors[CONSTANT] = hits(shortfall(gains, always, free)).astype(float)
    best = choices(gains, free)
    return {**floors, ORACLE: hits(shortfall(gains, best, free)).astype(float)}

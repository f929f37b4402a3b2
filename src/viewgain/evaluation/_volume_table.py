"""The table of volume planners: how often each takes a best position, and what it costs, with floors, oracle and ceiling."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import DataError
from viewgain.evaluation._bootstrap import Shares, shares_by_object
from viewgain.evaluation._decisions import JUDGED, constant_choices, guessed, judged
from viewgain.evaluation._plain import finite
from viewgain.evaluation._position_scores import PositionScores, agreement, best_positions, position_scores
from viewgain.evaluation._quantity import Quantity
from viewgain.evaluation._ratios import ratio
from viewgain.evaluation._risk import risks_at
from viewgain.evaluation._selective import Selective, selective
from viewgain.evaluation._volume_case import VolumeSettings
from viewgain.evaluation._volume_choices import CONSTANT, OFFSET, ORACLE, OTHER_CAMERAS, UNIFORM, VOLUME_FLOORS
from viewgain.evaluation._volume_runs import VolumeRun
from viewgain.plan import shipped_confidence

_STREAM, _SURE = 0x7633, 0x7634
"""Streams of intervals: of the table, and of what leaving out decisions brings, the same boxes for every row."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumeRow:
    """One way to choose."""

    name: str
    """What chooses."""
    shares: Shares
    """Best position, within 2 points of relative error of the best, expected error of the chosen position."""
    of_ceiling: Quantity
    """Share of best positions over the ceiling."""
    to_oracle: Quantity
    """Mean error over that of the oracle's choice."""
    kept: tuple[float, ...] = ()
    """Mean of how much worse than the best position its choice is, over the 50, 70, 90 and 100 % of boxes where it expects to be
    the furthest ahead of its next choice; empty where nothing decides."""
    sure: Selective | None = None
    """What leaving out the decisions brings that are least likely to be nearly best; None where nothing decides."""
    undecided: int = 0
    """Boxes on which it had no opinion and stayed."""
    milliseconds: float | None = None
    """Median CPU time of a decision, measuring included, one thread; None where nothing is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumeTable:
    """One table."""

    settings: VolumeSettings
    """What was asked."""
    boxes: int
    """How many."""
    first: int
    """Number of the first of them."""
    reachable: float
    """Mean number of positions that a camera could stand at."""
    best: float
    """Mean number of positions that count as best."""
    no_choice: int
    """Boxes whose positions all count as best: nothing can be chosen wrongly there."""
    missed: float
    """Share of all scans that gave no estimate."""
    ceiling: Shares
    """Split halves: how often the best position of one half counts as best in the other; how often both name the same."""
    rows: tuple[VolumeRow, ...]
    """Policies, floors, oracle."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON."""
        return {"columns": list(JUDGED), **finite({**dataclasses.asdict(self), "settings": self.settings.to_dict()})}


def volume_table(settings: VolumeSettings, runs: Sequence[VolumeRun], policies: Sequence[str]) -> VolumeTable:
    """Return the table of some runs.

    Args:
        settings: What they answer.
        runs: Of 2 boxes or more.
        policies: Names to show, in order; ``random``, ``constant`` and ``oracle`` ask for floors and ceiling.

    Raises:
        DataError: If there are fewer than two boxes.
    """
    if len(runs) < 2:
        raise DataError(f"evaluate volume: got {len(runs)} box, wanted 2 or more")
    half = settings.captures
    scoring = [position_scores(run.errors[:, :half], run.reachable) for run in runs]
    apart = [position_scores(run.errors[:, half:], run.reachable) for run in runs]
    oracle = judged(scoring, [other.least for other in apart])
    halves = np.array([agreement(one, other) for one, other in zip(scoring, apart, strict=True)])
    results = _results(runs, scoring, oracle, policies)
    boxes, rng = np.arange(len(runs)), np.random.default_rng([settings.seed, _STREAM])
    counts = [int(best_positions(each).sum()) for each in scoring]
    return VolumeTable(
        settings=settings,
        boxes=len(runs),
        first=min(run.number for run in runs),
        reachable=float(np.mean([run.reachable.sum() for run in runs])),
        best=float(np.mean(counts)),
        no_choice=sum(count == int(run.reachable.sum()) for count, run in zip(counts, runs, strict=True)),
        missed=float(np.mean(np.concatenate([np.isnan(run.errors[run.reachable]).ravel() for run in runs]))),
        ceiling=shares_by_object(halves, boxes, rng=rng),
        rows=tuple(
            VolumeRow(
                name=name,
                shares=shares_by_object(values, boxes, rng=rng),
                of_ceiling=ratio(values[:, 0], halves[:, 0], rng=rng),
                to_oracle=ratio(values[:, 2], oracle[:, 2], rng=rng),
                kept=_kept(runs, name, values, scoring),
                sure=_sure(runs, name, values, oracle, seed=settings.seed),
                undecided=sum(not run.choices[name].has_opinion for run in runs if name in run.choices),
                milliseconds=_median(runs, name),
            )
            for name, values in results.items()
        ),
    )


def _results(
    runs: Sequence[VolumeRun], scoring: Sequence[PositionScores], oracle: Array, policies: Sequence[str]
) -> Mapping[str, Array]:
    """Return (B, 3) judgements by the name of the row, in the order in which the policies are named."""
    floors: dict[str, Callable[[], Array]] = {
        UNIFORM: lambda: guessed(scoring),
        CONSTANT: lambda: judged(scoring, constant_choices(scoring).tolist()),
        OFFSET: lambda: judged(scoring, constant_choices(scoring, [run.present for run in runs]).tolist()),
        OTHER_CAMERAS: lambda: judged(scoring, [_by_others(run).least for run in runs]),
        ORACLE: lambda: oracle,
    }
    results: dict[str, Array] = {}
    for name in policies:
        for row in VOLUME_FLOORS.get(name, ()):
            results[row] = floors[row]()
        if name not in VOLUME_FLOORS:
            results[name] = judged(scoring, [run.choices[name].position for run in runs])
    return results


def _by_others(run: VolumeRun) -> PositionScores:
    if run.by_others is None:
        raise DataError(f"evaluate volume: got no scans of box {run.number} by other cameras, wanted them for {OTHER_CAMERAS}")
    return position_scores(run.by_others, run.reachable)


def _kept(runs: Sequence[VolumeRun], name: str, values: Array, scoring: Sequence[PositionScores]) -> tuple[float, ...]:
    if not all(name in run.choices for run in runs):
        return ()
    above = values[:, 2] - np.array([box.mean[box.least] for box in scoring])
    return risks_at([run.choices[name].margin for run in runs], above)


def _sure(runs: Sequence[VolumeRun], name: str, values: Array, oracle: Array, *, seed: int) -> Selective | None:
    if not all(name in run.numbers for run in runs):
        return None
    confidence = shipped_confidence()
    chances, margins = [confidence.chance(run.numbers[name]) for run in runs], [run.choices[name].margin for run in runs]
    return selective(chances, margins, values[:, 1], values[:, 2], oracle[:, 2], rng=np.random.default_rng([seed, _SURE]))


def _median(runs: Sequence[VolumeRun], name: str) -> float | None:
    spent = [run.milliseconds[name] for run in runs if name in run.milliseconds]
    return float(np.median(spent)) if spent else None

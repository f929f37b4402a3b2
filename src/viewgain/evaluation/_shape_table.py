"""The table of planners for objects of any shape: errors of the volumes after a second view, and the gap that is closed."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import DataError
from viewgain.evaluation._bootstrap import Shares, ratio_by_object, shares_by_object
from viewgain.evaluation._decisions import constant_choices, guessed, judged
from viewgain.evaluation._plain import finite
from viewgain.evaluation._position_scores import PositionScores, agreement, best_positions, position_scores
from viewgain.evaluation._shape_case import VOLUMES
from viewgain.evaluation._shape_runs import ShapeRun
from viewgain.evaluation._shape_settings import ShapeSettings
from viewgain.evaluation._volume_choices import CONSTANT, FLOORS, OFFSET, ORACLE, UNIFORM
from viewgain.gain import costs

_STREAM = 0x7368


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeRow:
    """One way to choose. Of every pair of figures the first is of the hull, the second of the standing box."""

    name: str
    """What chooses."""
    error: Shares
    """Mean |relative error| of the volume after the second view."""
    closed: Shares | None
    """Share of the gap from a uniform guess to the oracle that is closed; None where there is no gap."""
    best: Shares
    """How often the choice is a best position."""
    undecided: int = 0
    """Objects on which it had no opinion and went to the farthest position."""
    milliseconds: float | None = None
    """Median CPU time of a decision, one thread; None where nothing is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeTable:
    """One table."""

    settings: ShapeSettings
    """What was asked."""
    objects: int
    """How many."""
    first: Shares
    """Mean |relative error| by the first scan alone."""
    bias: Shares
    """Mean relative error after a second scan, over all positions: below 0 is too small."""
    reachable: float
    """Mean number of positions that a camera could go to."""
    counted: tuple[float, ...]
    """Mean number of them that count as best."""
    ceiling: Shares
    """Split halves: how often the best position of one half counts as best in the other."""
    rows: tuple[ShapeRow, ...]
    """Policies, floors, oracle."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON."""
        plain: dict[str, Any] = finite({**dataclasses.asdict(self), "settings": self.settings.to_dict()})
        return {"volumes": list(VOLUMES), **plain}


def shape_table(runs: Sequence[ShapeRun], settings: ShapeSettings, policies: Sequence[str]) -> ShapeTable:
    """Return the table of some runs.

    Args:
        runs: Of 2 objects or more.
        settings: What they answer.
        policies: Names to show, in order; ``random``, ``constant`` and ``oracle`` ask for floors and ceiling.

    Raises:
        DataError: If there are fewer than two objects.
    """
    if len(runs) < 2:
        raise DataError(f"evaluate shapes: got {len(runs)} object, wanted 2 or more")
    half, objects = settings.captures, np.arange(len(runs))
    rng = np.random.default_rng([settings.seed, _STREAM])
    scoring = [[position_scores(run.errors[k, :, :half], run.reachable) for run in runs] for k in range(len(VOLUMES))]
    apart = [[position_scores(run.errors[k, :, half:], run.reachable) for run in runs] for k in range(len(VOLUMES))]
    guess = np.stack([guessed(each) for each in scoring])
    oracle = np.stack([judged(each, [other.least for other in others]) for each, others in zip(scoring, apart, strict=True)])
    halves = np.array([
        [agreement(one, other)[0] for one, other in zip(*pair, strict=True)] for pair in zip(scoring, apart, strict=True)
    ]).T  # fmt: skip
    signed = np.stack([np.clip(run.errors[:, run.reachable], -1, 1).reshape(len(VOLUMES), -1) for run in runs])

    def row(name: str, values: Array) -> ShapeRow:
        error, gap = values[..., 2].T, (guess - oracle)[..., 2].T
        return ShapeRow(
            name=name,
            error=shares_by_object(error, objects, rng=rng),
            closed=ratio_by_object(guess[..., 2].T - error, gap, objects, rng=rng),
            best=shares_by_object(values[..., 0].T, objects, rng=rng),
            undecided=sum(not run.choices[name].has_opinion for run in runs if name in run.choices),
            milliseconds=_median(runs, name),
        )

    return ShapeTable(
        settings=settings,
        objects=len(runs),
        first=shares_by_object(costs(np.stack([run.first for run in runs])), objects, rng=rng),
        bias=shares_by_object(np.nan_to_num(signed, nan=-1.0).mean(axis=2), objects, rng=rng),
        reachable=float(np.mean([run.reachable.sum() for run in runs])),
        counted=tuple(float(np.mean([best_positions(each).sum() for each in scores])) for scores in scoring),
        ceiling=shares_by_object(halves, objects, rng=rng),
        rows=tuple(row(name, values) for name, values in _results(runs, scoring, guess, oracle, policies).items()),
    )


def _results(
    runs: Sequence[ShapeRun],
    scoring: Sequence[Sequence[PositionScores]],
    guess: Array,
    oracle: Array,
    policies: Sequence[str],
) -> Mapping[str, Array]:
    """Return (2, B, 3) judgements by the name of the row, in the order in which the policies are named."""
    present = [run.present for run in runs]
    floors: dict[str, Callable[[], Array]] = {
        UNIFORM: lambda: guess,
        CONSTANT: lambda: np.stack([judged(each, constant_choices(each).tolist()) for each in scoring]),
        OFFSET: lambda: np.stack([judged(each, constant_choices(each, present).tolist()) for each in scoring]),
        ORACLE: lambda: oracle,
    }
    results: dict[str, Array] = {}
    for name in policies:
        for floor in FLOORS.get(name, ()):
            results[floor] = floors[floor]()
        if name not in FLOORS:
            results[name] = np.stack([judged(each, [run.choices[name].position for run in runs]) for each in scoring])
    return results


def _median(runs: Sequence[ShapeRun], name: str) -> float | None:
    spent = [run.milliseconds[name] for run in runs if name in run.milliseconds]
    return float(np.median(spent)) if spent else None

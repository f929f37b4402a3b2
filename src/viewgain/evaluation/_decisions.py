"""What decisions about positions are worth: judged on scans that nobody decided by, with what answers without learning get."""

from collections.abc import Sequence

import numpy as np

from viewgain.arrays import Array, Indices
from viewgain.errors import DataError
from viewgain.evaluation._position_scores import PositionScores, best_positions
from viewgain.plan import NEARLY

JUDGED = ("best position", "within 2 points", "error")
"""What each decision is judged by; the names of the columns."""
_SLACK = 1e-12


def judged(scores: Sequence[PositionScores], chosen: Sequence[int]) -> Array:
    """Return (B, 3) for each box whether the chosen position counts as best, whether it is nearly best, its expected error.

    Args:
        scores: Of B boxes.
        chosen: (B,) positions.

    Raises:
        DataError: If a chosen position is not allowed, or there is not one choice per box.
    """
    if len(scores) != len(chosen) or not all(box.allowed[place] for box, place in zip(scores, chosen, strict=True)):
        raise DataError(f"decisions: got {len(chosen)} choices for {len(scores)} boxes, wanted one allowed position of each")
    return np.array([worth(box)[place] for box, place in zip(scores, chosen, strict=True)]).reshape(-1, len(JUDGED))


def guessed(scores: Sequence[PositionScores]) -> Array:
    """Return (B, 3) what :func:`judged` gives on average for a uniformly drawn allowed position, in closed form."""
    return np.array([worth(box)[box.allowed].mean(axis=0) for box in scores]).reshape(-1, len(JUDGED))


def constant_choices(scores: Sequence[PositionScores], start: Sequence[int] | None = None) -> Indices:
    """Return (B,) the constant answer for each box: the position with the least mean error over all *other* boxes.

    Where the constant answer is not allowed the next best one is given. Of equals the lowest counts.

    Args:
        scores: Of B boxes on a rig of V positions, B of 2 or more.
        start: (B,) present positions, to answer with a constant number of positions on from there; None for a constant position.

    Raises:
        DataError: If there are fewer than two boxes.
    """
    if len(scores) < 2:
        raise DataError(f"decisions: got {len(scores)} box, wanted 2 or more, so that a constant answer is chosen on others")
    shifts = np.zeros(len(scores), dtype=np.intp) if start is None else np.asarray(start, dtype=np.intp)
    rows = np.stack([np.roll(box.mean, -shift) for box, shift in zip(scores, shifts, strict=True)])
    counted = np.isfinite(rows)
    sums, numbers = np.nansum(rows, axis=0), counted.sum(axis=0)
    chosen = np.empty(len(rows), dtype=np.intp)
    for place, row in enumerate(rows):
        left = sums - np.nan_to_num(row), numbers - counted[place]
        others = np.where(left[1] > 0, left[0] / np.maximum(left[1], 1), np.inf)
        chosen[place] = np.argmin(np.where(counted[place], np.minimum(others, np.finfo(float).max), np.inf))
    return np.asarray((chosen + shifts) % rows.shape[1], dtype=np.intp)


def worth(scores: PositionScores) -> Array:
    """Return (V, 3) what choosing each position of a box would be worth (:data:`JUDGED`); NaN errors where not allowed."""
    with np.errstate(invalid="ignore"):
        nearly = scores.mean - scores.mean[scores.least] <= NEARLY + _SLACK
    return np.column_stack([best_positions(scores), nearly, scores.mean]).astype(float)

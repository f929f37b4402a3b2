"""How good each position of a rig is for measuring one box: expected volume errors, and which of them nobody can tell apart."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from viewgain.arrays import Mask, Vector
from viewgain.errors import DataError
from viewgain.gain import costs

ALIKE = 2.0
"""Two positions whose means differ by at most so many standard errors of the difference count as equally good."""


@dataclass(frozen=True, slots=True, eq=False)
class PositionScores:
    """The expected relative volume error of every position, as far as n scans of each tell."""

    mean: Vector
    """(V,) expected |relative volume error|, a miss counted as 1; the lower the better. NaN for a position not allowed."""
    error: Vector
    """(V,) its standard error; 0 where all scans err alike, NaN of a single scan."""
    allowed: Mask
    """(V,) positions that a camera can stand at."""

    @property
    def least(self) -> int:
        """The allowed position with the least expected error, of equal ones the lowest index."""
        return int(np.argmin(np.where(self.allowed, self.mean, np.inf)))


def position_scores(errors: ArrayLike, allowed: ArrayLike) -> PositionScores:
    """Return the scores of one box's positions.

    Args:
        errors: (V, n) relative volume errors V / V* - 1 of n scans from each position; NaN for a miss.
        allowed: (V,) positions that count; what stands in the rows of others is not looked at.

    Raises:
        DataError: If there is no allowed position or no scan.
    """
    table, free = np.asarray(errors, dtype=float), np.asarray(allowed, dtype=bool)
    if table.ndim != 2 or table.shape[1] == 0 or free.shape != table.shape[:1] or not free.any():
        raise DataError(
            f"positions: got errors {table.shape} and {int(free.sum())} allowed positions, wanted (positions, scans), one of each"
            " at least"
        )
    spent, count = costs(table), table.shape[1]
    spread = spent.std(axis=1, ddof=1) if count > 1 else np.full(len(spent), np.nan)
    return PositionScores(
        np.where(free, spent.mean(axis=1), np.nan), np.where(free, spread / np.sqrt(count), np.nan), free.copy()
    )


def best_positions(scores: PositionScores) -> Mask:
    """Return (V,) the positions that count as best: those within two standard errors of the one with the least mean.

    Scans from different positions are independent, so the standard error of a difference is the root of the sum of squares.
    Of single scans, whose spread nobody knows, only equal means count.
    """
    least = scores.least
    apart = scores.mean - scores.mean[least]
    unsure = np.nan_to_num(np.hypot(scores.error, scores.error[least]))
    with np.errstate(invalid="ignore"):
        return np.asarray(scores.allowed & (apart <= ALIKE * unsure))


def agreement(first: PositionScores, second: PositionScores) -> tuple[float, float]:
    """Return how well two halves of a box's scans agree on the best position, symmetric in the halves.

    Returns:
        Whether the position with the least mean in one half counts as best in the other (0, a half or 1, the mean of both ways):
        the ceiling for anyone who is judged by such a half. And whether both name the same position (0 or 1).
    """
    across = (best_positions(second)[first.least], best_positions(first)[second.least])
    return float(np.mean(across)), float(first.least == second.least)

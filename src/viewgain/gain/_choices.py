"""What a choice is worth: the coverage it gives away against the best view (paper, Table 1)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewgain.arrays import Array, Vector
from viewgain.errors import ConfigError

POSITION_LIMITS = (0.0, 0.05, 0.03, 0.01, 0.005)
"""Differences in coverage that still count as right: exact position, then the approximate positions in the paper's order."""
POSITION_SLACK = 1e-6
"""Gains are stored in single precision: what is over a limit by so little is within it. One point of a surface is more."""


def choices(scores: ArrayLike, free: ArrayLike | None = None) -> NDArray[np.intp]:
    """Return (N,) the view of the highest score, of equal scores the first.

    Args:
        scores: (N, V).
        free: (N, V) views that may be chosen: those not visited yet; None for all.

    Raises:
        ConfigError: If a sample has no free view.
    """
    highest: NDArray[np.intp] = np.argmax(only_free(scores, free), axis=1)
    return highest


def shortfall(gains: ArrayLike, chosen: ArrayLike, free: ArrayLike | None = None) -> Vector:
    """Return (N,) the gain of the best view minus the gain of the chosen one; infinite where that one was not free.

    Args:
        gains: (N, V) what each view adds to the coverage, share of the surface.
        chosen: (N,) indices of views.
        free: (N, V) views that may be chosen; None for all.

    Raises:
        ConfigError: If a sample has no free view.
    """
    allowed = only_free(gains, free)
    picked = np.take_along_axis(allowed, np.asarray(chosen, dtype=np.intp)[:, None], axis=1)[:, 0]
    lost: Vector = allowed.max(axis=1) - picked
    return lost


def hits(lost: ArrayLike) -> NDArray[np.bool_]:
    """Return (..., 5) whether a shortfall (...) is within each of :data:`POSITION_LIMITS`.

    Ties: a view that is worth as much as the best one *is* the best, whichever of them the labels name first. The published
    program's log rows are counted so as well, where the exact position is a difference of 0.
    """
    return np.asarray(lost, dtype=float)[..., None] <= np.array(POSITION_LIMITS) + POSITION_SLACK


def only_free(values: ArrayLike, free: ArrayLike | None) -> Array:
    """Return (N, V) the values as float, minus infinity where a view is not free.

    Raises:
        ConfigError: If a sample has no free view.
    """
    table = np.array(values, dtype=float)
    if free is None:
        return table
    if not np.all(np.any(free, axis=1)):
        raise ConfigError("choice: got a sample whose views were all visited, wanted at least one that is left to choose")
    return np.where(free, table, -np.inf)

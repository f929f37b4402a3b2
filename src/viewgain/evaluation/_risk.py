"""What is gained by not deciding where a planner is unsure: risk by the share of decisions that are kept."""

import numpy as np
from numpy.typing import ArrayLike

from viewgain.arrays import Vector
from viewgain.errors import DataError

KEPT = (0.5, 0.7, 0.9, 1.0)
"""Shares of decisions at which tables give the risk."""


def risk_coverage(confidence: ArrayLike, risk: ArrayLike) -> tuple[Vector, Vector]:
    """Return (B,) shares of decisions kept, and the (B,) mean risk of those, the surest kept first.

    Decisions of equal confidence are kept or left together as far as their risk goes: each counts with the mean of its equals, so
    the order in which they are given changes nothing.

    Args:
        confidence: (B,) any numbers, the higher the surer.
        risk: (B,) what each decision costs.

    Raises:
        DataError: If there is no decision, or not one confidence each.
    """
    sure, lost = np.asarray(confidence, dtype=float), np.asarray(risk, dtype=float)
    if sure.ndim != 1 or sure.shape != lost.shape or len(sure) == 0 or not np.all(np.isfinite(sure)):
        raise DataError(f"risk: got confidences {sure.shape} and risks {lost.shape}, wanted as many finite ones, 1 or more")
    _, group = np.unique(-sure, return_inverse=True)
    mean = np.bincount(group, lost) / np.bincount(group)
    ordered = mean[np.sort(group)]
    count = np.arange(1, len(sure) + 1)
    return count / len(sure), np.cumsum(ordered) / count


def risks_at(confidence: ArrayLike, risk: ArrayLike, kept: tuple[float, ...] = KEPT) -> tuple[float, ...]:
    """Return the mean risk where these shares of decisions are kept, each rounded up to whole decisions; raises as above."""
    share, mean = risk_coverage(confidence, risk)
    places = np.minimum(np.ceil(np.array(kept) * len(share) - 1e-9).astype(int), len(share))
    return tuple(float(mean[max(place, 1) - 1]) for place in places)

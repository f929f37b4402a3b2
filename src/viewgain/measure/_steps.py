"""A step in the sides beneath one top: the seam of two boxes, the lower one a little wider, its own top too narrow to be seen.

A ledge of a few millimetres to two centimetres is no patch of its own, yet hundreds of pixels above and below it know the offset
of either side to a fraction of a millimetre (ours).
"""

import numpy as np

from viewgain.arrays import Array
from viewgain.measure._patches import Patch

MIN_STEP = 0.004
"""A smaller step may be a dent or a fold of the carton, metres."""
SURE_STEP = 8.0
"""A step must pass this many of its own standard deviations."""
_CUTS = 24
_MIN_BESIDE = 40


def seam_height(sides: list[Patch]) -> float | None:
    """Return the height above the floor at which the sides of a box step outwards, metres; None where they do not.

    Each side is fitted by a quadric (a bulge is no step) with and without a step at each of 24 heights; at the height with
    the most evidence of a step, in or out, a side must step out by 4 mm and eight standard deviations of that step.

    Args:
        sides: The upright patches beneath one top, frame of the floor.
    """
    if not sides:
        return None
    heights = np.concatenate([side.points[:, 2] for side in sides])
    low, high = np.quantile(heights, [0.03, 0.97])
    cuts = np.linspace(low, high, _CUTS + 2)[1:-1]
    steps = [[_step(side, cut) for cut in cuts] for side in sides]
    evidence = np.array([[min(abs(ratio), 1e3) ** 2 for _, ratio in row] for row in steps])
    best = int(np.argmax(evidence.sum(axis=0)))
    stepped = any(row[best][0] > MIN_STEP and row[best][1] > SURE_STEP for row in steps)
    return float(cuts[best]) if stepped else None


def _step(side: Patch, cut: float) -> tuple[float, float]:
    """Return by how much a side steps out beneath a height, metres, and that over its standard deviation; zeros for too few."""
    points = side.points[:: max(1, len(side.points) // 1500)]
    below = points[:, 2] < cut
    if min(below.sum(), (~below).sum()) < _MIN_BESIDE:
        return 0.0, 0.0
    along = points @ np.array([-side.normal[1], side.normal[0], 0.0])
    u, z = _scaled(along), _scaled(points[:, 2])
    terms = np.column_stack([below, np.ones(len(u)), u, z, u * u, z * z])
    away = side.beyond(points)
    fit = np.linalg.lstsq(terms, away, rcond=None)[0]
    sigma = float(np.std(away - terms @ fit)) * np.sqrt(np.linalg.pinv(terms.T @ terms)[0, 0])
    return float(fit[0]), float(fit[0] / max(sigma, 1e-9))


def _scaled(values: Array) -> Array:
    return np.asarray((values - values.mean()) / max(float(values.std()), 1e-9))

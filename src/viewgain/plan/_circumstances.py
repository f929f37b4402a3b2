"""In numbers, under what circumstances a box would be measured: what the learned part of the expected error goes by (ours)."""

from collections.abc import Sequence

import numpy as np

from viewgain.arrays import Array, Vector
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.measure import MAX_SLENDER, Knowledge
from viewgain.plan._belief import relative_sigma
from viewgain.plan._showing import Showing

CIRCUMSTANCES = 39
"""How many numbers."""
_SIGMA = (1e-4, 10.0)
"""Relative standard deviations are told within these."""
_LEAST_SHARE = 0.01
"""Less floor in view is told as this share."""


def circumstances(box: Box, known: Knowledge, seen: Sequence[Showing], sensor: Sensor) -> Vector:
    """Return (39,) numbers about measuring a box from one view or several together.

    They do not depend on frames, nor on which side of the box is called x: its longer horizontal side comes first.

    Args:
        box: The box.
        known: What the views say together.
        seen: What each shows; one or more.
        sensor: The camera.
    """
    order = np.array([0, 1, 2] if box.extents[0] >= box.extents[1] else [1, 0, 2])
    extents = box.extents[order]
    sigma = np.sqrt(np.diag(known.covariance(sensor))[6:])[order] / extents
    ends = np.max([view.ends for view in seen], axis=0)[order]
    borders, corners, distances, elevations = (
        [getattr(view, name) for view in seen] for name in ("border", "corners", "distance", "elevation")
    )
    nearest = np.array([min(distances)])
    return np.concatenate([
        np.log(extents),
        np.log(np.clip([*sigma, relative_sigma(known, box, sensor)], *_SIGMA)),
        np.any([view.spanned for view in seen], axis=0)[order],
        ends.min(axis=1), ends.max(axis=1),
        [max(corners), min(corners)],
        np.sqrt([min(borders), max(borders)]), [min(borders) > 0, max(borders) > 0],
        _returns(np.array([view.returns for view in seen]), order),
        np.log([min(distances), max(distances)]), [min(elevations), max(elevations)],
        [len(seen) - 1, np.log(extents[2] / extents[0] / MAX_SLENDER)],
        np.log([sensor.intrinsics.fx, float(sensor.range_sigma(nearest, np.ones(1))[0])]),
        _floor(seen), [max(view.clearance for view in seen)],
    ])  # fmt: skip


def _returns(returns: Array, order: Array) -> Vector:
    """Return (6,) logarithms of returns: of the fullest view, of the top, of the sides across the first and the second axis."""
    faces = returns.max(axis=0)
    across = faces[:4].reshape(2, 2)[order[:2]]
    numbers = [returns.sum(axis=1).max(), faces[4], *across.max(axis=1), *across.min(axis=1)]
    return np.asarray(np.log(np.maximum(numbers, 1.0)))


def _floor(seen: Sequence[Showing]) -> Vector:
    """Return (2,) how much floor the views show at most: logarithms of the returns from it, and of its share of the area."""
    returns, share = (max(getattr(view.floor, name) for view in seen) for name in ("returns", "share"))
    return np.log([max(returns, 1.0), max(share, _LEAST_SHARE)])

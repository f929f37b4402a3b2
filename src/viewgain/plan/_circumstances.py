"""In numbers, under what circumstances a box would be measured: what the learned part of the expected error goes by (ours)."""

from collections.abc import Sequence

import numpy as np

from viewgain.arrays import Array, Mask
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.measure import MAX_SLENDER, Knowledge
from viewgain.plan._belief import extent_sigmas, relative_sigma
from viewgain.plan._showing import Showing

CIRCUMSTANCES = 39
"""How many numbers."""
_SIGMA = (1e-4, 10.0)
"""Relative standard deviations are told within these."""
_LEAST_SHARE = 0.01
"""Less floor in view is told as this share."""


def circumstances(box: Box, known: Knowledge, seen: Sequence[Showing], sensor: Sensor) -> Array:
    """Return (39,) numbers about measuring a box from one view or several together.

    They do not depend on frames, nor on which side of the box is called x: its longer horizontal side comes first.

    Args:
        box: The box, or a stack of n: then (n, 39), and all that follows is of n too.
        known: What the views say together.
        seen: What each shows; one or more.
        sensor: The camera.
    """
    turned = box.extents[..., :1] < box.extents[..., 1:2]
    extents = _longer_first(box.extents, turned)
    sigma = _longer_first(extent_sigmas(known, sensor), turned) / extents
    ends = _longer_first(np.max([view.ends for view in seen], axis=0).mT, turned[..., None])
    borders, corners, distances, elevations = (
        np.array([getattr(view, name) for view in seen]) for name in ("border", "corners", "distance", "elevation")
    )
    nearest = distances.min(axis=0)
    return np.concatenate([
        np.log(extents),
        np.log(np.clip(sigma, *_SIGMA)),
        _columns(np.log(np.clip(relative_sigma(known, box, sensor), *_SIGMA))),
        _longer_first(np.any([view.spanned for view in seen], axis=0), turned),
        ends.min(axis=-2), ends.max(axis=-2),
        _columns(
            corners.max(axis=0), corners.min(axis=0),
            np.sqrt(borders.min(axis=0)), np.sqrt(borders.max(axis=0)), borders.min(axis=0) > 0, borders.max(axis=0) > 0,
        ),
        _returns(np.array([view.returns for view in seen]), turned),
        _columns(
            np.log(nearest), np.log(distances.max(axis=0)), elevations.min(axis=0), elevations.max(axis=0),
            np.full_like(nearest, len(seen) - 1), np.log(extents[..., 2] / extents[..., 0] / MAX_SLENDER),
            np.full_like(nearest, np.log(sensor.intrinsics.fx)), np.log(sensor.range_sigma(nearest, np.ones_like(nearest))),
        ),
        _floor(seen), _columns(np.max([view.clearance for view in seen], axis=0)),
    ], axis=-1)  # fmt: skip


def _longer_first(values: Array, turned: Mask) -> Array:
    """Return (..., 3) values of the axes of a box, with x and y swapped where ``turned`` (..., 1) says so."""
    return np.where(turned, values[..., [1, 0, 2]], values)


def _columns(*numbers: Array) -> Array:
    return np.stack(numbers, axis=-1)


def _returns(returns: Array, turned: Mask) -> Array:
    """Return (6,) logarithms of returns: of the fullest view, of the top, of the sides across the first and the second axis."""
    faces = returns.max(axis=0)
    x, y = faces[..., 0:2], faces[..., 2:4]
    first, second = np.where(turned, y, x), np.where(turned, x, y)
    numbers = _columns(
        returns.sum(axis=-1).max(axis=0), faces[..., 4],
        first.max(axis=-1), second.max(axis=-1), first.min(axis=-1), second.min(axis=-1),
    )  # fmt: skip
    return np.log(np.maximum(numbers, 1.0))


def _floor(seen: Sequence[Showing]) -> Array:
    """Return (2,) how much floor the views show at most: logarithms of the returns from it, and of its share of the area."""
    returns, share = (np.max([getattr(view.floor, name) for view in seen], axis=0) for name in ("returns", "share"))
    return np.log(_columns(np.maximum(returns, 1.0), np.maximum(share, _LEAST_SHARE)))

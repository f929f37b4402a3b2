"""How much of the floor around a box a camera would see: without a floor nothing is measured (ours)."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices
from viewgain.box import Box, box_hits, entry_mask, floor_hits
from viewgain.camera import Sensor

ROWS, COLUMNS = 12, 16
"""Rays over the image, evenly."""
_LEAST_COSINE = 0.1
"""Areas seen at a smaller cosine count as seen at this one, as in measuring."""


@dataclass(frozen=True, slots=True)
class FloorInView:
    """What an image shows of the floor; arrays (n,) of a stack."""

    returns: Array | float
    """Expected number of pixels on it."""
    share: Array | float
    """Its part of the area seen, square metres of it over those of box and floor, 0 to 1: what measuring finds a floor by."""

    def take(self, chosen: Indices | int) -> "FloorInView":
        """Return some of a stack, or one of it."""
        return FloorInView(np.asarray(self.returns)[chosen], np.asarray(self.share)[chosen])


def floor_in_view(box: Box, sensor: Sensor) -> FloorInView:
    """Return what ``sensor`` sees of the floor that ``box``, in the camera's frame, stands on; nothing else is in view.

    Nothing where all of it is out of range, hidden by the box, or above the horizon. Takes a stack.
    """
    directions = sensor.intrinsics.directions()
    rays = directions[np.ix_(_places(directions.shape[0], ROWS), _places(directions.shape[1], COLUMNS))].reshape(-1, 3)
    on_box = entry_mask(box, rays)
    near, far = box_hits(box, rays), floor_hits(box, rays)
    ranges, cosine = np.where(on_box, near.ranges, far.ranges), np.where(on_box, near.cosine, far.cosine)
    returned = (ranges > sensor.range_min) & (ranges < sensor.range_max)
    kept = returned * (1 - sensor.loss(cosine))
    area = kept * np.where(returned, ranges, 0.0) ** 2 / np.maximum(cosine, _LEAST_COSINE)
    pixels = directions.size / rays.size
    share = np.sum(area * ~on_box, axis=-1) / np.maximum(area.sum(axis=-1), np.finfo(float).tiny)
    return FloorInView(pixels * np.sum(kept * ~on_box, axis=-1), share)


def _places(pixels: int, count: int) -> Indices:
    """Return the middle pixels of ``count`` equal stretches of a row or column."""
    return ((np.arange(count) + 0.5) / count * pixels).astype(np.intp)

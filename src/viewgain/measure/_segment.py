"""What stands on the floor: connected groups of pixels above it, split where the range jumps."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from viewgain.arrays import Image, Mask
from viewgain.measure._floor import Floor
from viewgain.measure._range_image import RangeImage

MIN_PIXELS = 60
"""An object with fewer pixels is not measured."""
_JUMP = 0.03
_BESIDE_PX = 4
_EIGHT = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """A scan split into objects on a floor."""

    labels: Image
    """(h, w) integers: 0 is floor or nothing, k is the k-th largest object."""
    heights: Image
    """(h, w) height above the floor, metres; NaN where nothing came back."""
    count: int
    """Number of objects."""


def segment(image: RangeImage, floor: Floor, *, min_height: float | None = None) -> Segments:
    """Return the objects on ``floor``, largest first.

    Pixels on a range jump (over 3 cm plus 2 % between neighbours) are left out: they are flying pixels or edges, and without
    them boxes one behind the other fall apart into separate objects.

    Args:
        image: The scan.
        floor: Its floor.
        min_height: Pixels lower than this belong to the floor, metres; default four floor spreads, at least 1.5 cm.
    """
    heights = floor.plane.height(image.points)
    threshold = max(0.015, min(4 * floor.spread, 0.04)) if min_height is None else min_height
    with np.errstate(invalid="ignore"):
        above = image.valid & (heights > threshold)
    above &= ~_on_jump(image.ranges)
    joined = above if image.organised else ndimage.binary_closing(above, _EIGHT) | above
    labels, count = ndimage.label(joined, _EIGHT)
    sizes = np.bincount(np.where(above, labels, 0).ravel(), minlength=count + 1)
    sizes[0] = 0
    order = np.argsort(-sizes)
    order = order[sizes[order] >= MIN_PIXELS]
    rank = np.zeros(count + 1, dtype=np.intp)
    rank[order] = np.arange(1, len(order) + 1)
    return Segments(np.where(above, rank[labels], 0), heights, len(order))


def beside(own: Mask, objects: list[Mask]) -> list[int]:
    """Return the numbers of the other ``objects`` that come within four pixels of ``own`` in the image."""
    near = ndimage.binary_dilation(own, _EIGHT, iterations=_BESIDE_PX)
    return [k for k, other in enumerate(objects) if other is not own and np.any(near & other)]


def _on_jump(ranges: Image) -> Mask:
    """Return the (h, w) mask of pixels in front of or on a range jump to a direct neighbour."""
    jump = np.zeros(ranges.shape, dtype=bool)
    with np.errstate(invalid="ignore"):
        for axis in (0, 1):
            step = np.abs(np.diff(ranges, axis=axis)) > _JUMP + 0.02 * np.minimum(
                np.take(ranges, range(1, ranges.shape[axis]), axis), np.take(ranges, range(ranges.shape[axis] - 1), axis)
            )
            first = [slice(None)] * 2
            second = [slice(None)] * 2
            first[axis], second[axis] = slice(None, -1), slice(1, None)
            jump[tuple(first)] |= step
            jump[tuple(second)] |= step
    return jump

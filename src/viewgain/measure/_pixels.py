"""Which pixels speak about one object: its own, a margin around them, and a sample of the floor."""

import numpy as np
from scipy import ndimage

from viewgain.arrays import Indices, Mask
from viewgain.box import Box, edge_distances, outline
from viewgain.measure._mixture import Pixels
from viewgain.measure._range_image import RangeImage

MARGIN = 12
"""How far around an object pixels are looked at, pixels."""
_EDGE_BAND = 4.0


def pixels_around(image: RangeImage, own: Mask, other: Mask) -> Pixels:
    """Return the pixels in the bounding rectangle of ``own`` widened by a margin that grows with the object.

    Args:
        image: The scan.
        own: (h, w) pixels of the object.
        other: (h, w) pixels of other objects.
    """
    rows, columns = (np.flatnonzero(own.any(axis=axis)) for axis in (1, 0))
    margin = MARGIN + (len(rows) + len(columns)) // 16
    window = (
        slice(max(rows[0] - margin, 0), rows[-1] + margin + 1),
        slice(max(columns[0] - margin, 0), columns[-1] + margin + 1),
    )
    known = image.known[window].ravel()
    directions = image.directions[window].reshape(-1, 3)[known]
    ranges = image.ranges[window].ravel()[known]
    return Pixels(
        directions,
        directions[:, :2] / directions[:, 2:],
        ranges,
        other[window].ravel()[known],
        np.ones(len(ranges)),
        image.pitch,
        float(np.nanquantile(image.ranges[::4, ::4], 0.995)),
        image.plane,
    )


def thinned(pixels: Pixels, count: int) -> Pixels:
    """Return about ``count`` evenly strided pixels, each with the weight of those it stands for."""
    stride = max(1, len(pixels.ranges) // count)
    return pixels.take(np.arange(0, len(pixels.ranges), stride), pixels.weight[::stride] * stride)


def edges_kept(pixels: Pixels, box: Box, count: int) -> Pixels:
    """Return all pixels within four pixels of the outline of ``box`` (thinned where they are very many), and ``count`` others."""
    distance = np.abs(edge_distances(outline(box), pixels.image).distance) / pixels.pitch
    near, rest = np.flatnonzero(distance < _EDGE_BAND), np.flatnonzero(distance >= _EDGE_BAND)
    near_stride, rest_stride = max(1, len(near) // (2 * count)), max(1, len(rest) // count)
    chosen: Indices = np.concatenate([near[::near_stride], rest[::rest_stride]])
    weight = np.concatenate(
        [np.full(len(near[::near_stride]), float(near_stride)), np.full(len(rest[::rest_stride]), float(rest_stride))]
    )
    return pixels.take(chosen, weight * pixels.weight[chosen])


def leftover(own: Mask, image: RangeImage, box: Box) -> list[Mask]:
    """Return the parts of ``own`` that lie outside the fitted box's outline and are large enough to be objects themselves."""
    flat = image.directions[own]
    outside = np.zeros(own.shape, dtype=bool)
    distance = edge_distances(outline(box), flat[:, :2] / flat[:, 2:]).distance / image.pitch
    outside[own] = distance < -2.0
    labels, count = ndimage.label(ndimage.binary_opening(outside), np.ones((3, 3)))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    least = max(150, 0.05 * own.sum())
    return [labels == k for k in range(1, count + 1) if sizes[k] >= least]

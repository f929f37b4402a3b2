"""How box-like an object is, from the pixels alone."""

import numpy as np

from viewgain.arrays import Array, Mask, Pose
from viewgain.box import Box, box_hits, entry_mask
from viewgain.geometry import pose
from viewgain.measure import RangeImage
from viewgain.parcels._objects import SeenObject, smoothed
from viewgain.parcels._smallest import Cuboid

_SHARE = 0.03
"""A pixel agrees with a box up to this share of the box's size, plus two pixels and two sigma of its smoothed range."""


def box_likeness(image: RangeImage, seen: SeenObject, cuboids: tuple[Cuboid, ...]) -> float:
    """Return in [0, 1] how much an object looks like one of its own enclosing boxes (ours).

    The share of pixels that agree with the box, among those that see the object or would see the box: a box has nearly all of
    them; a ball touches its box in a few spots, and the box's corners stand in the air. The best of the boxes counts.

    Args:
        image: The scan.
        seen: The object.
        cuboids: Its enclosing boxes, floor frame.
    """
    return max(_agreement(image, seen, _standing(cuboid, seen.floor_frame)) for cuboid in cuboids)


def _agreement(image: RangeImage, seen: SeenObject, box: Box) -> float:
    window = _window(seen.mask)
    mask, rays = seen.mask[window].ravel(), image.directions[window].reshape(-1, 3)
    ranges = image.ranges[window].ravel().copy()
    ranges[mask] = smoothed(image, seen.mask)
    size = float(np.exp(np.mean(np.log(np.maximum(box.extents, 1e-3)))))
    tolerance = _SHARE * size + 2 * seen.pitch + seen.sigma
    with np.errstate(invalid="ignore"):
        hits = box_hits(box, rays)
        off = np.abs(ranges - hits.ranges) * np.maximum(hits.cosine, 0.2)
        agree = mask & (off < tolerance)
        through = entry_mask(box, rays) & (ranges > hits.ranges + tolerance / np.maximum(hits.cosine, 0.2))
    return float(agree.sum() / max((mask | through).sum(), 1))


def _window(mask: Mask) -> tuple[slice, slice]:
    """Return the rows and columns of the object, with a margin for what its box sticks out."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    margin = 2 + (len(rows) + len(columns)) // 4
    return slice(max(rows[0] - margin, 0), rows[-1] + margin + 1), slice(max(columns[0] - margin, 0), columns[-1] + margin + 1)


def _standing(cuboid: Cuboid, floor_to_camera: Pose) -> Box:
    """Return the cuboid as a box whose own z axis is the most upright of its axes, camera frame."""
    axes: Array = cuboid.centred_to_frame[:3, :3]
    up = int(np.argmax(np.abs(axes[2])))
    z = axes[:, up] * (1.0 if axes[2, up] > 0 else -1.0)
    x = axes[:, (up + 1) % 3]
    frame = np.stack([x, np.cross(z, x), z], axis=1)
    extents = np.maximum(cuboid.extents[[(up + 1) % 3, (up + 2) % 3, up]], 1e-3)
    bottom = cuboid.centred_to_frame[:3, 3] - z * extents[2] / 2
    return Box(floor_to_camera @ pose(frame, bottom), extents)

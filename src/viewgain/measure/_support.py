"""What a part of a stack stands on, what boxes explain, and the room that two of them share."""

import numpy as np

from viewgain.arrays import Array, Mask
from viewgain.box import Box, box_hits, entry_mask
from viewgain.geometry import inverse, transform
from viewgain.measure._grouping import Group
from viewgain.measure._range_image import RangeImage

_SHARE_ABOVE = 0.2
_MARGIN = 0.01
_SAG = 0.025
_AGREES = 0.012


def support_height(part: Group, boxes: list[Box], placing: Array) -> float:
    """Return how high above the floor a part stands: 0 on the floor, else the height of the highest top beneath it.

    A box carries the part if at least a fifth of the part's points lie over its footprint, and its top is no higher than the
    part's lowest points.

    Args:
        part: The part, frame of the floor.
        boxes: Boxes measured so far, camera frame.
        placing: (4, 4) pose of the floor's frame in the camera's.
    """
    heights = [0.0]
    for box in boxes:
        top = float(np.median((transform(inverse(placing), box.corners()[4:]))[:, 2]))
        local = transform(inverse(box.box_to_camera) @ placing, part.points)
        over = np.all(np.abs(local[:, :2]) < box.extents[:2] / 2 + _MARGIN, axis=1)
        if over.mean() > _SHARE_ABOVE and top < part.bottom + _SAG and top < part.top - _SAG:
            heights.append(top)
    return max(heights)


def explained_by(boxes: list[Box], image: RangeImage, mask: Mask) -> float:
    """Return the share of the pixels of ``mask`` whose range lies within 12 mm of the surface of one of ``boxes``."""
    directions, ranges = image.directions[mask], image.ranges[mask]
    explained = np.zeros(len(ranges), dtype=bool)
    for box in boxes:
        apart = np.abs(box_hits(box, directions).ranges - ranges)
        explained |= entry_mask(box, directions) & (apart < _AGREES)
    return float(explained.mean()) if len(ranges) else 1.0


def shared_room(box: Box, other: Box) -> float:
    """Return the share of the volume of ``box`` that lies within ``other``, counted on 10 x 10 x 10 points."""
    steps = (np.arange(10) + 0.5) / 10 - 0.5
    grid = np.stack(np.meshgrid(steps, steps, steps + 0.5, indexing="ij"), axis=-1).reshape(-1, 3) * box.extents
    local = transform(inverse(other.box_to_camera) @ box.box_to_camera, grid)
    middle = local - (0, 0, other.extents[2] / 2)
    return float(np.mean(np.all(np.abs(middle) < other.extents / 2, axis=1)))

"""From one scan to the enclosing boxes of everything on the floor, one step per line."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Array
from viewgain.camera import Sensor
from viewgain.measure import RangeImage, find_floors, range_image, sensor_of
from viewgain.parcels._calibration import calibration
from viewgain.parcels._enclosure import EnclosingBox, Enclosure, Enclosures, Estimate
from viewgain.parcels._likeness import box_likeness
from viewgain.parcels._objects import SeenObject, find_objects
from viewgain.parcels._smallest import Cuboid
from viewgain.parcels._statistics import features, seen_and_possible
from viewgain.scans import Scan

CUT = 0.02
"""An object is cut if this share of its outline lies on the image's border."""
LOST = 0.35
"""If this much of it does, nothing is measured."""
HIDDEN = 0.1
"""An object is hidden if something stands before this share of its outline."""
FEW_POINTS = 300
"""An object with fewer returns is flagged."""


def enclose(scan: Scan, *, camera: str | Sensor | None = None, floor: Scan | None = None) -> Enclosures:
    """Measure the smallest enclosing boxes and the volumes of whatever stands on the floor of one scan.

    Args:
        scan: The scan, camera frame.
        camera: Preset name or sensor, for its noise and its known scale and offset error; its image is the scan's own.
        floor: A scan of the empty scene from the same pose, where the object hides the floor.

    Returns:
        The objects, largest in the image first, or none and a reason. Objects that touch are one.

    Raises:
        ConfigError: If ``camera`` names no preset.
    """
    known = sensor_of(camera)
    image = range_image(scan).corrected(known)
    model = replace(known, intrinsics=image.whole_camera())
    floors = find_floors(image if floor is None else range_image(floor).corrected(known), model)
    if not floors:
        return Enclosures((scan.source,), None, (), "no_floor")
    objects = find_objects(image, floors[0], model)
    kept = tuple(enclosure(image, seen) for seen in objects if seen.border < LOST)
    reason = None if kept else "cut_by_border" if objects else "nothing_on_floor"
    return Enclosures((scan.source,), floors[0], kept, reason)


def enclosure(image: RangeImage, seen: SeenObject) -> Enclosure:
    """Return the finished record of one object: statistics of what is seen and what is possible, then calibrated intervals."""
    near, far = seen_and_possible(seen)
    factors = calibration().quantiles(features(seen, near, far))
    bounded = seen.border < CUT and seen.hidden < HIDDEN
    each = [_estimate(value, row, bounded) for value, row in zip(near.values, factors, strict=True)]
    return Enclosure(
        upright=_box(each[0:4], near.upright, seen),
        free=_box(each[4:8], near.free, seen),
        hull_volume=each[8],
        heap_volume=each[9],
        box_likeness=box_likeness(image, seen, (near.upright, near.free)),
        flags=_flags(seen),
        returns=len(seen.points),
        centre=np.asarray(image.points[seen.mask].mean(axis=0)),
        mask=seen.mask,
    )


def _estimate(seen: float, factors: Array, bounded: bool) -> Estimate:
    low, value, high = (float(seen * factor) for factor in factors)
    return Estimate(value, low, high if bounded else None, float(seen))


def _box(estimates: list[Estimate], cuboid: Cuboid, seen: SeenObject) -> EnclosingBox:
    a, b, c, volume = estimates
    return EnclosingBox((a, b, c), volume, seen.floor_frame @ cuboid.centred_to_frame)


def _flags(seen: SeenObject) -> tuple[str, ...]:
    named = {"cut": seen.border >= CUT, "hidden": seen.hidden >= HIDDEN, "few_points": len(seen.points) < FEW_POINTS}
    return tuple(name for name, holds in named.items() if holds)

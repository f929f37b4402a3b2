"""From one scan to measured boxes: the whole method, one step per line."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Mask
from viewgain.camera import Sensor, sensor
from viewgain.measure._bare_floor import bare_floor
from viewgain.measure._floor import Floor, find_floors
from viewgain.measure._range_image import RangeImage, range_image
from viewgain.measure._result import BoxEstimate, Measurement, Rejected
from viewgain.measure._segment import segment
from viewgain.measure._single import OnFloor, Refusal
from viewgain.measure._stack import MAX_OBJECTS, objects
from viewgain.scans import Scan


def measure(scan: Scan, *, camera: str | Sensor | None = None, floor: Scan | None = None) -> Measurement:
    """Measure the boxes on the floor of one scan.

    Floor, objects on it, first guesses, maximum likelihood, uncertainty, flags: in that order, from the scan alone. Where
    several planes can be the floor (a table before a wall), the one whose boxes explain most of the scan is taken.

    Args:
        scan: The scan, camera frame.
        camera: Preset name or sensor, for its noise and systematic error; its image is the scan's own. Without it the noise
            is estimated from the scan and the systematic error is the default sensor's (0.3 % scale, 3 mm offset).
        floor: A scan of the empty scene from the same pose, for stations where the box hides the floor.

    Returns:
        The boxes, largest in the image first, or none and a reason.

    Raises:
        ConfigError: If ``camera`` names no preset.
    """
    known = sensor_of(camera)
    image = range_image(scan).corrected(known)
    model = replace(known, intrinsics=image.whole_camera())
    floors = find_floors(image, model) if floor is None else _floors_of(range_image(floor).corrected(known), image, model)
    attempts = [_on_floor(image, candidate, model, noise_known=camera is not None) for candidate in floors]
    if not attempts:
        attempts = [Measurement((), None, (), "no_floor")]
    best = max(attempts, key=_explained)
    return replace(best, scans=(scan.source,), camera_to_world=scan.camera_to_world, notes=scan.notes)


def _floors_of(empty: RangeImage, image: RangeImage, model: Sensor) -> list[Floor]:
    """Return the floors of an empty scene, as evidence where the scan itself shows too little of them."""
    found = find_floors(empty, model)
    return [replace(floor, bare=bare_floor(floor.plane, floor.spread, empty, image)) for floor in found]


def _explained(attempt: Measurement) -> tuple[int, bool]:
    """Return how many returns lie on boxes that the scan bounds, then whether there is any box; of equals the first floor wins.

    An unbounded "box" is no evidence for a floor: with a wall or a box's own side for a floor, the true floor looks like one.
    """
    return sum(box.quality.returns for box in attempt.boxes if not any(box.is_open)), bool(attempt.boxes)


UNKNOWN_JITTER = 0.3
"""Where a pixel of a camera that nobody named may really look, pixels: its slopes are taken for noisier (assumed)."""
UNKNOWN_SHORT = 0.03
"""How much of the floor beside an object its image shows short: chosen between 0 and 0.1 by two scans of a Kinect."""


def sensor_of(camera: str | Sensor | None) -> Sensor:
    """Return the sensor that a name, a sensor or nothing stands for."""
    if isinstance(camera, Sensor):
        return camera
    if camera is None:
        return replace(sensor("pico_flexx"), jitter_px=UNKNOWN_JITTER, short_floor=UNKNOWN_SHORT)
    return sensor(camera)


def _on_floor(image: RangeImage, floor: Floor, model: Sensor, *, noise_known: bool) -> Measurement:
    """Return the boxes and the rejected objects on one floor."""
    segments = segment(image, floor)
    scene = OnFloor(image, floor, model, segments.labels > 0, noise_known)
    found = objects(scene, [segments.labels == k for k in range(1, min(segments.count, MAX_OBJECTS) + 1)])[:MAX_OBJECTS]
    boxes = tuple(one.result for one in found if isinstance(one.result, BoxEstimate))
    rejected = [_rejected(one.result, scene, one.own) for one in found if isinstance(one.result, Refusal)]
    reason = None if boxes else rejected[0].reason if rejected else "nothing_on_floor"
    return Measurement((), floor, boxes, reason, tuple(sorted(rejected, key=lambda refused: -refused.returns)))


def _rejected(refusal: Refusal, scene: OnFloor, own: Mask) -> Rejected:
    points = scene.image.points[own]
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    return Rejected(refusal.reason, len(points), points.mean(axis=0), (high - low) / 2, scene.model, refusal.estimate)

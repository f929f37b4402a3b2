"""What is believed after a scan: a set of boxes, whatever it showed.

A well-seen box is one box with its covariance. A dimension that was left open is spread over its stated prior, with the seen
face held still; where somebody says about where the box stands, over what of it fits there. A mere blob on the floor is a box of
the blob's size, known to a third of it. Where nothing was measured, a place and the scan still leave some boxes.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from viewgain.arrays import Array, Indices, Pose, Poses, Vector
from viewgain.box import PARAMETERS, Box
from viewgain.camera import Sensor
from viewgain.geometry import floor_to_camera, inverse, pose
from viewgain.measure import LOOSE_PRIOR, PRIOR_EXTENT, SYSTEMATIC, BoxEstimate, Knowledge, Measurement, Rejected, range_image
from viewgain.plan._belief import Belief
from viewgain.plan._place import Place
from viewgain.plan._possible_boxes import possible_boxes
from viewgain.scans import Scan

SPREAD = (1, 5, 3, 2)
"""Number of boxes that stand for each open dimension, by how many are open."""
FINE = (1, 40, 12, 6)
"""The same where the place of the box says which of them are likely, before as many as above are kept."""
ELSEWHERE = -8.0
"""Log odds of a centre four standard deviations from the place: a box that comes no nearer stands elsewhere."""
GLIMPSED = 9
"""Number of boxes that stand for a scan in which nothing was measured."""
_FILTER_SEED = 0
"""The same scan and place give the same boxes."""
TYPICAL_EXTENT = 1.2
"""An open dimension is taken to be at most this long, metres, unless it is already longer."""
LEAST_REACH = 0.6
"""An open dimension is considered up to at least this, metres, whatever its interval says: the evidence against a longer one is
missing returns alone, and a plan that is good for longer boxes too costs little."""


def believe(measured: Measurement, sensor: Sensor, place: Place | None = None, scans: Sequence[Scan] = ()) -> Belief | None:
    """Return what is believed about the largest box in the image, else the largest rejected object, else what fits the scan.

    Args:
        measured: What the scans say.
        sensor: The camera, for a scan in which nothing was measured; what was says which it was.
        place: Where the box stands, in the last scan's camera frame; None where nobody knows (:func:`belief_from`).
        scans: The scans so far. Where nothing was measured, the one whose pose the measurement has is looked at
            (:func:`belief_from_glimpse`); that need not be the last.

    Returns:
        None where nothing was measured, and there is no place, or no such scan.
    """
    if measured.boxes:
        return belief_from(measured.boxes[0], place)
    if measured.rejected:
        blob = measured.rejected[0]
        return belief_from_blob(blob, measured) if blob.estimate is None else belief_from(blob.estimate, place)
    here = measured.camera_to_world
    scan = None if here is None else _taken_at(here, scans)
    if place is None or scan is None or here is None:
        return None
    return belief_from_glimpse(scan, here, place, sensor)


def _taken_at(here: Pose, scans: Sequence[Scan]) -> Scan | None:
    """Return the last scan of a pose."""
    posed = (scan for scan in reversed(scans) if scan.camera_to_world is not None and np.array_equal(scan.camera_to_world, here))
    return next(posed, None)


def belief_from(estimate: BoxEstimate, place: Place | None = None) -> Belief:
    """Return the belief after measuring a box: one box, or several where dimensions are open.

    Args:
        estimate: The measured box.
        place: Where a box stands, in the estimate's frame; None where nobody knows. It chooses among the lengths of open
            dimensions, and moves nothing that was measured. A box that would stand far from it whatever its length is another
            one, of which it says nothing.
    """
    missing = int(np.sum(estimate.is_open))
    boxes = _spread(estimate, SPREAD[missing])
    if place is not None and missing:
        fine = _spread(estimate, FINE[missing])
        odds = place.log_odds(np.array([box.centre for box in fine]))
        if odds.max() >= ELSEWHERE:
            boxes = [fine[index] for index in _quantiles(odds, len(boxes))]
    view, bounded = estimate.views[0], not any(estimate.is_open)
    return Belief(tuple(boxes), estimate.knowledge, view.sensor, view.noise, bounded, cameras=_cameras(estimate))


def _cameras(estimate: BoxEstimate) -> Poses:
    """Return (k, 4, 4) ``camera_to_current`` of the scans that a box was measured in."""
    there = [np.eye(4) if view.reference_to_camera is None else view.reference_to_camera for view in estimate.views]
    return np.stack([inverse(each) for each in there])


def _spread(estimate: BoxEstimate, count: int) -> list[Box]:
    """Return the measured box with ``count`` lengths of every open dimension in all combinations, the smallest first."""
    ridge_of = np.linalg.inv(estimate.knowledge.information + LOOSE_PRIOR)
    axes = np.flatnonzero(estimate.is_open).tolist()
    boxes = []
    for lengths in product(*(_lengths(estimate, axis, count) for axis in axes)):
        box = estimate.box
        for axis, length in zip(axes, lengths, strict=True):
            ridge = ridge_of[:, 6 + axis] / ridge_of[6 + axis, 6 + axis]
            box = box.moved(ridge * (length - estimate.box.extents[axis]))
        boxes.append(Box(box.box_to_camera, np.maximum(box.extents, 0.01)))
    return sorted(boxes, key=lambda box: box.volume)


def _lengths(estimate: BoxEstimate, axis: int, count: int) -> Vector:
    """Return (count,) lengths that stand for what is possible of an open dimension: quantiles of the log-uniform prior."""
    interval = estimate.intervals[axis]
    low = max(interval.low, PRIOR_EXTENT[0])
    high = max(interval.high if np.isfinite(interval.high) else TYPICAL_EXTENT, LEAST_REACH, 1.5 * low)
    return np.asarray(low * max(high / low, 1.01) ** ((np.arange(count) + 0.5) / count))


def _quantiles(odds: Vector, count: int) -> Indices:
    """Return ``count`` ascending indices, each as often as its log odds say: those at equally spaced sums of the weights."""
    sums = np.cumsum(np.exp(odds - odds.max()))
    return np.asarray(np.searchsorted(sums, (np.arange(count) + 0.5) / count * sums[-1]))


def belief_from_glimpse(scan: Scan, camera_to_world: Pose, place: Place, sensor: Sensor) -> Belief:
    """Return the belief after a scan in which nothing could be measured: boxes at a place that explain what is seen.

    Args:
        scan: The scan.
        camera_to_world: (4, 4) its pose; the world's z is up.
        place: Where a box stands, camera frame.
        sensor: The camera.
    """
    boxes = possible_boxes(scan.points, camera_to_world[2, :3], place, GLIMPSED, rng=np.random.default_rng(_FILTER_SEED))
    extents = np.mean([box.extents for box in boxes], axis=0)
    here = replace(sensor, intrinsics=range_image(scan).whole_camera())
    return Belief(boxes, _known_to_a_third(extents, height=3 / extents[2]), here, 1.0, bounded=False, guessed=True, glimpsed=True)


def belief_from_blob(blob: Rejected, current: Measurement) -> Belief:
    """Return the belief about an object that could not be measured: its bounding box, each number known to a third."""
    assert current.floor is not None
    placing = floor_to_camera(current.floor.plane)
    corners = blob.centre + blob.spread * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    local = (corners - placing[:3, 3]) @ placing[:3, :3]
    middle = (blob.centre - placing[:3, 3]) @ placing[:3, :3]
    reach = np.maximum(np.abs(local - middle).mean(axis=0), 0.03)
    extents = np.array([2 * reach[0], 2 * reach[1], max(middle[2] + reach[2], 0.05)])
    box = Box(placing @ pose(np.eye(3), np.array([middle[0], middle[1], 0.0])), extents)
    return Belief((box,), _known_to_a_third(extents), blob.sensor, current.floor.noise, bounded=False, guessed=True)


def _known_to_a_third(extents: Array, height: float = 20.0) -> Knowledge:
    """Return knowledge of a box that nothing measured: sides and place to a third, the floor's height to 1 / ``height``."""
    third = np.concatenate([np.full(2, 50.0), [0.5], np.repeat(3 / extents.mean(), 2), [height], 3 / extents]) ** 2
    return Knowledge(np.diag(third), np.zeros((PARAMETERS, SYSTEMATIC)))

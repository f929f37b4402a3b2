"""From one scan to measured boxes: the whole method, one step per line."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Mask
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.geometry import Plane, floor_to_camera
from viewgain.measure._fit import COARSE, FINE, SHARP, Fit, View, estimate_noise, polled, refine
from viewgain.measure._floor import Floor, find_floors
from viewgain.measure._grouping import groups
from viewgain.measure._hypotheses import hypotheses
from viewgain.measure._patches import patches
from viewgain.measure._pixels import edges_kept, leftover, pixels_around, thinned
from viewgain.measure._quality import FEW_POINTS, Quality, assess, flags, widened
from viewgain.measure._range_image import RangeImage, range_image
from viewgain.measure._result import BoxEstimate, Measurement, Rejected
from viewgain.measure._segment import MIN_PIXELS, beside, segment
from viewgain.measure._support import explained_by, support_height
from viewgain.measure._uncertainty import extent_interval, knowledge
from viewgain.scans import Scan

MAX_OBJECTS = 12
"""At most this many objects of one scan are tried."""
MIN_HEIGHT = 0.02
"""Lower objects are told from the floor's own unevenness no longer, metres."""
MAX_LEFTOVER = 0.8
"""If more than this share of an object lies outside the fitted box, the fit is wrong rather than the object two."""
MIN_SHARE = 0.005
"""A box that is cut or open must fill this share of the image; smaller ones are clutter more often than boxes."""
MIN_SHARE_CUT_OPEN = 0.02
"""The same for a box that is both: legs and furniture at the border of the image look like that."""
SURE_EXPLAINED = 0.95
"""A box that explains less of what lies within its outline is tried as several boxes."""
SURE_OVERLAP = 0.92
"""The same for the overlap of outline and object."""
MIN_STACK_SHARE = 0.6
"""Several boxes must explain this share of an object together: a bag or a chair has flat patches too."""
STACK_GAIN = 1.03
"""They must explain so much more than the object taken for one box and its leftovers."""
MIN_PART = 0.02
"""A part of a stack with a smaller share of the object is a fragment, not a box; without a top, twice that."""
SUPPORT_BAND = 0.01
"""Pixels this near to the plane that a box stands on show its support, metres."""
_COARSE_PIXELS = 1200
_FINE_PIXELS = 1600
_FINAL_PIXELS = 12000
_POLL_PX = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Refusal:
    """Why an object is not reported as a box, and the box it would have been."""

    reason: str
    """A key of :data:`viewgain.measure.REASONS`."""
    estimate: BoxEstimate | None = None
    """The fit, where the object is a box but too little of it is seen."""


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
    floors = find_floors(image if floor is None else range_image(floor).corrected(known), model)
    attempts = [_on_floor(image, candidate, model, noise_known=camera is not None) for candidate in floors]
    if not attempts:
        attempts = [Measurement((), None, (), "no_floor")]
    best = max(attempts, key=_explained)
    return replace(best, scans=(scan.source,), camera_to_world=scan.camera_to_world, notes=scan.notes)


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
    scene = _OnFloor(image, floor, model, segments.labels > 0, noise_known)
    objects = [segments.labels == k for k in range(1, min(segments.count, MAX_OBJECTS) + 1)]
    outcomes = [_object(scene, own) for own in objects]
    for k, own in enumerate(objects):
        if _returns(outcomes[k]) == 0 and (near := beside(own, objects)):
            pooled = np.logical_or.reduce([own, *(objects[other] for other in near)])
            plain = [one for other in (k, *near) for one in outcomes[other]]
            outcomes[k] = _better(_stack(scene, pooled), plain, pooled)
            for other in near:
                outcomes[other] = []
    found = [one for several in outcomes for one in several][:MAX_OBJECTS]
    boxes = tuple(one.result for one in found if isinstance(one.result, BoxEstimate))
    rejected = [_rejected(one.result, image, one.own) for one in found if isinstance(one.result, Refusal)]
    reason = None if boxes else rejected[0].reason if rejected else "nothing_on_floor"
    return Measurement((), floor, boxes, reason, tuple(sorted(rejected, key=lambda refused: -refused.returns)))


@dataclass(frozen=True, slots=True, eq=False)
class _OnFloor:
    """What all objects of one scan share."""

    image: RangeImage
    floor: Floor
    model: Sensor
    taken: Mask
    """(h, w) pixels of all objects."""
    noise_known: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Outcome:
    """A box or the reason against it, and the pixels it was fitted to."""

    result: BoxEstimate | Refusal
    own: Mask


def _object(scene: _OnFloor, own: Mask) -> list[_Outcome]:
    """Return what one connected object is: a box, a box and what is left beside it, or where that explains more, a stack."""
    outcomes: list[_Outcome] = []
    queue = [(own, False)]
    while queue and len(outcomes) < MAX_OBJECTS:
        part, split_off = queue.pop(0)
        result, parts = _estimate(scene, part, touching=split_off)
        queue += [(rest, True) for rest in parts]
        outcomes.append(_Outcome(result, part))
    if len(outcomes) == 1 and not _doubtful(outcomes[0].result):
        return outcomes
    return _better(_stack(scene, own), outcomes, own)


def _better(stacked: list[_Outcome], plain: list[_Outcome], own: Mask) -> list[_Outcome]:
    """Return the reading of an object as a stack if it explains most of the object, and more than the plain reading does."""
    explained = _returns(stacked)
    enough = explained > MIN_STACK_SHARE * own.sum() and explained > STACK_GAIN * _returns(plain)
    return stacked if enough else plain


def _doubtful(result: BoxEstimate | Refusal) -> bool:
    """Return whether an object is perhaps several: no box, or one that leaves more unexplained than noise would."""
    if isinstance(result, Refusal):
        return result.reason == "not_a_box"
    return result.quality.explained < SURE_EXPLAINED or result.quality.overlap < SURE_OVERLAP


def _returns(outcomes: list[_Outcome]) -> int:
    return sum(one.result.quality.returns for one in outcomes if isinstance(one.result, BoxEstimate))


def _stack(scene: _OnFloor, own: Mask) -> list[_Outcome]:
    """Return the boxes of an object split into flat patches, each on the floor or on the box beneath it."""
    placing = floor_to_camera(scene.floor.plane)
    noise = scene.floor.noise * float(np.median(scene.model.range_sigma(scene.image.ranges[own], np.array(0.7))))
    found = patches(scene.image, own, scene.floor, scene.model, placing)
    parts = groups(found, scene.image, noise)
    parts = [part for part in parts if len(part.pixels) >= max(MIN_PIXELS, (1 if part.has_top else 2) * MIN_PART * own.sum())]
    masks = [part.mask(own.shape) for part in parts]
    outcomes: list[_Outcome] = []
    for part, mask in zip(parts, masks, strict=True):
        boxes = [one.result.box for one in outcomes if isinstance(one.result, BoxEstimate)]
        if explained_by(boxes, scene.image, mask) > 0.5:
            continue
        if part.tilted:
            outcomes.append(_Outcome(Refusal("tilted"), mask))
            continue
        height = support_height(part, boxes, placing)
        others = np.logical_or.reduce([scene.taken & ~own, *(other for other in masks if other is not mask)])
        outcomes.append(_Outcome(_on_support(scene, mask, others, height), mask))
    return sorted(outcomes, key=lambda one: -int(one.own.sum()))


def _on_support(scene: _OnFloor, own: Mask, others: Mask, height: float) -> BoxEstimate | Refusal:
    """Return the box fitted to one part of a stack that stands at ``height`` above the floor, or the reason against it."""
    image, floor = scene.image, scene.floor
    if height > 0:
        floor = replace(floor, plane=Plane(floor.plane.normal, floor.plane.offset - height))
        others = image.valid & ~own & (others | (np.abs(floor.plane.height(image.points)) > 3 * SUPPORT_BAND))
        others &= ~(np.abs(floor.plane.height(image.points)) < SUPPORT_BAND)
    fit = _fit(image, floor, own, others, scene.model, noise_known=scene.noise_known)
    result = _judged(fit, image, floor, own, touching=True)
    if height > 0 and isinstance(result, BoxEstimate):
        return replace(result, flags=(*result.flags, "stacked"))
    return result


def _estimate(scene: _OnFloor, own: Mask, *, touching: bool) -> tuple[BoxEstimate | Refusal, list[Mask]]:
    """Return the box fitted to one object, or the reason against it, and the parts of the object that are not this box."""
    if own.sum() < MIN_PIXELS:
        return Refusal("too_few_points"), []
    image, floor, model, noise_known = scene.image, scene.floor, scene.model, scene.noise_known
    other = scene.taken & ~own
    fit = _fit(image, floor, own, other, model, noise_known=noise_known)
    parts = leftover(own, image, fit.box)
    rest = np.logical_or.reduce([np.zeros_like(own), *parts])
    if parts and rest.sum() < MAX_LEFTOVER * own.sum():
        own, other = own & ~rest, other | rest
        fit = _fit(image, floor, own, other, model, noise_known=noise_known, start=fit.box)
    else:
        parts = []
    return _judged(fit, image, floor, own, touching=touching or bool(parts)), parts


def _fit(
    image: RangeImage, floor: Floor, own: Mask, other: Mask, model: Sensor, *, noise_known: bool, start: Box | None = None
) -> Fit:
    """Return the box of greatest likelihood: rough from every guess on few pixels, then sharp on many, then on all."""
    pixels = pixels_around(image, own, other)
    guesses = [start] if start is not None else hypotheses(image.points[own], floor)
    coarse = View(thinned(pixels, _COARSE_PIXELS), model, floor.noise)
    blurred = max((refine(guess, (coarse,), COARSE[:1], 2) for guess in guesses), key=lambda fit: fit.value)
    rough = refine(blurred.box, (coarse,), COARSE, 6)
    view = View(edges_kept(pixels, rough.box, _FINE_PIXELS), model, noise_of(rough, noise_known=noise_known))
    fit = refine(rough.box, (view,), FINE, 6)
    moved = polled(fit, SHARP[0], _POLL_PX * image.pitch * float(np.linalg.norm(fit.box.centre)))
    if moved is not fit.box:
        fit = refine(moved, (view,), FINE, 6)
    final = View(edges_kept(pixels, fit.box, _FINAL_PIXELS), model, noise_of(fit, noise_known=noise_known))
    return refine(fit.box, (final,), SHARP, 3)


def noise_of(fit: Fit, *, noise_known: bool) -> float:
    """Return the noise factor of a one-view fit: estimated, and for a named camera at least its data sheet's."""
    return max(estimate_noise(fit)[0], 1.0 if noise_known else 0.0)


def _judged(fit: Fit, image: RangeImage, floor: Floor, own: Mask, *, touching: bool) -> BoxEstimate | Refusal:
    """Return the finished estimate, or the reason why the object is not reported as a box."""
    evaluation, view = fit.evaluations[0], fit.views[0]
    sigma = floor.noise * view.sensor.range_sigma(evaluation.hits.ranges, evaluation.hits.cosine)
    quality = assess(fit.box, evaluation, view.pixels, image, own, sigma)
    if quality.returns < MIN_PIXELS:
        return Refusal("too_few_points")
    if not quality.is_box or fit.box.extents[2] < max(MIN_HEIGHT, 3 * floor.spread):
        return Refusal(quality.why_not)
    estimate = with_uncertainty(fit, quality, touching=touching)
    partial = set(estimate.flags) & {"cut", "open"}
    if (partial or touching) and quality.returns < max(FEW_POINTS, MIN_SHARE * image.ranges.size):
        return Refusal("too_few_points", estimate)
    if all(estimate.is_open) or (len(partial) == 2 and quality.returns < MIN_SHARE_CUT_OPEN * image.ranges.size):
        return Refusal("cut_by_border", estimate)
    return estimate


def with_uncertainty(fit: Fit, quality: Quality, *, touching: bool) -> BoxEstimate:
    """Return the finished estimate of a fit: covariance, intervals, flags."""
    known = knowledge(fit)
    spread = widened(known.covariance(fit.views[0].sensor), quality)
    x, y, z = (extent_interval(axis, fit, known, spread, cut=quality.cut, spanned=quality.spans(axis)) for axis in range(3))
    bare = BoxEstimate(fit.box, known, spread, (x, y, z), quality, (), fit.views)
    return replace(bare, flags=flags(quality, is_open=any(bare.is_open), touching=touching))


def _rejected(refusal: Refusal, image: RangeImage, own: Mask) -> Rejected:
    points = image.points[own]
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    return Rejected(refusal.reason, len(points), points.mean(axis=0), (high - low) / 2, refusal.estimate)

"""One object taken for one box: fit, judgement, and what is left beside it."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Mask
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.measure._fit import COARSE, FINE, SHARP, Fit, View, climbed, estimate_noise, polled, refine
from viewgain.measure._floor import Floor
from viewgain.measure._hypotheses import hypotheses
from viewgain.measure._pixels import edges_kept, leftover, pixels_around, thinned
from viewgain.measure._quality import FEW_POINTS, Quality, assess, flags, widened
from viewgain.measure._range_image import RangeImage
from viewgain.measure._result import BoxEstimate
from viewgain.measure._segment import MIN_PIXELS
from viewgain.measure._uncertainty import Shown, extent_interval, knowledge

MIN_HEIGHT = 0.02
"""Lower objects are told from the floor's own unevenness no longer, metres."""
MAX_LEFTOVER = 0.8
"""If more than this share of an object lies outside the fitted box, the fit is wrong rather than the object two."""
MIN_SHARE = 0.005
"""A box that is cut or open must fill this share of the image; smaller ones are clutter more often than boxes."""
MIN_SHARE_CUT_OPEN = 0.02
"""The same for a box that is both: legs and furniture at the border of the image look like that."""
_COARSE_PIXELS = 1200
_FINE_PIXELS = 1600
_FINAL_PIXELS = 12000
_POLL_PX = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class OnFloor:
    """What all objects of one scan share."""

    image: RangeImage
    floor: Floor
    model: Sensor
    taken: Mask
    """(h, w) pixels of all objects."""
    noise_known: bool


@dataclass(frozen=True, slots=True, eq=False)
class Refusal:
    """Why an object is not reported as a box, and the box it would have been."""

    reason: str
    """A key of :data:`viewgain.measure.REASONS`."""
    estimate: BoxEstimate | None = None
    """The fit, where the object is a box but too little of it is seen."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A box or the reason against it, and the pixels it was fitted to."""

    result: BoxEstimate | Refusal
    own: Mask


def single(scene: OnFloor, own: Mask, *, touching: bool) -> tuple[BoxEstimate | Refusal, list[Mask]]:
    """Return the box fitted to one object, or the reason against it, and the parts of the object that are not this box."""
    if own.sum() < MIN_PIXELS:
        return Refusal("too_few_points"), []
    image, floor, model, noise_known = scene.image, scene.floor, scene.model, scene.noise_known
    other = scene.taken & ~own
    fit = fitted(image, floor, own, other, model, noise_known=noise_known)
    parts = leftover(own, image, fit.box)
    rest = np.logical_or.reduce([np.zeros_like(own), *parts])
    if parts and rest.sum() < MAX_LEFTOVER * own.sum():
        own, other = own & ~rest, other | rest
        fit = fitted(image, floor, own, other, model, noise_known=noise_known, start=fit.box)
    else:
        parts = []
    return judged(fit, image, floor, own, touching=touching or bool(parts)), parts


def fitted(
    image: RangeImage, floor: Floor, own: Mask, other: Mask, model: Sensor, *, noise_known: bool, start: Box | None = None
) -> Fit:
    """Return the box of greatest likelihood: rough from every guess on few pixels, then sharp on many, then on all."""
    pixels = pixels_around(image, own, other)
    guesses = [start] if start is not None else hypotheses(image.points[own], floor)
    coarse = View(thinned(pixels, _COARSE_PIXELS), model, floor.noise, bare=floor.bare)
    blurred = max((refine(guess, (coarse,), COARSE[:1], 2) for guess in guesses), key=lambda fit: fit.value)
    rough = climbed(blurred, COARSE, 6)
    view = replace(coarse, pixels=edges_kept(pixels, rough.box, _FINE_PIXELS), noise=noise_of(rough, noise_known=noise_known))
    fit = refine(rough.box, (view,), FINE, 6)
    moved = polled(fit, _POLL_PX * image.pitch * float(np.linalg.norm(fit.box.centre)))
    if moved is not fit.box:
        fit = refine(moved, (view,), FINE, 6)
    final = replace(view, pixels=edges_kept(pixels, fit.box, _FINAL_PIXELS), noise=noise_of(fit, noise_known=noise_known))
    return refine(fit.box, (final,), SHARP, 3)


def noise_of(fit: Fit, *, noise_known: bool) -> float:
    """Return the noise factor of a one-view fit: estimated, and for a named camera at least its data sheet's."""
    return max(estimate_noise(fit)[0], 1.0 if noise_known else 0.0)


def judged(
    fit: Fit, image: RangeImage, floor: Floor, own: Mask, *, touching: bool, stacked: bool = False
) -> BoxEstimate | Refusal:
    """Return the finished estimate, or the reason why the object is not reported as a box.

    Among boxes of one stack what floats beside the upper part of one is another, and no flap.
    """
    evaluation, view = fit.evaluations[0], fit.views[0]
    sigma = floor.noise * view.sensor.range_sigma(evaluation.hits.ranges, evaluation.hits.cosine)
    quality = assess(fit.box, evaluation, view.pixels, image, own, sigma)
    if stacked:
        quality = replace(quality, evidence=replace(quality.evidence, flaps=0.0))
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
    shown = [Shown(quality.cut, quality.spans(axis), quality.reach(axis)) for axis in range(3)]
    x, y, z = (extent_interval(axis, fit, known, spread, shown[axis]) for axis in range(3))
    bare = BoxEstimate(fit.box, known, spread, (x, y, z), quality, (), fit.views)
    return replace(bare, flags=flags(quality, is_open=any(bare.is_open), touching=touching))

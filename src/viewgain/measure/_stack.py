"""One object, one box or several: where boxes touch or stand on each other, flat patches tell them apart."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Mask
from viewgain.geometry import Plane, floor_to_camera
from viewgain.measure._grouping import Group, groups
from viewgain.measure._patches import patches
from viewgain.measure._result import BoxEstimate
from viewgain.measure._segment import MIN_PIXELS, beside
from viewgain.measure._single import OnFloor, Outcome, Refusal, fitted, judged, single
from viewgain.measure._support import explained_by, shared_room, support_height
from viewgain.measure._uncertainty import Z90, Interval

MAX_OBJECTS = 12
"""At most this many objects of one scan are tried."""
SURE_EXPLAINED = 0.95
"""A box that explains less of what lies within its outline is tried as several boxes."""
SURE_OVERLAP = 0.97
"""The same for the overlap of outline and object."""
MIN_STACK_SHARE = 0.6
"""Several boxes must explain this share of an object together: a bag or a chair has flat patches too."""
MIN_STACK_SHARE_ALONE = 0.8
"""The same where nothing of the object taken for one thing is a box."""
MAX_CURVED = 0.5
"""An object of which a larger share bends as no carton does is no box, whatever fits it."""
STACK_GAIN = 1.03
"""They must explain so much more than the object taken for one box and its leftovers."""
MIN_PART = 0.02
"""A part of a stack with a smaller share of the object is a fragment, not a box; without a top, twice that."""
MIN_SECOND_FACE = 0.03
"""A face with a smaller share of a box's returns is no evidence of a corner."""
MAX_SHARED_ROOM = 0.3
"""Of two boxes of which one shares more of its volume with the other, one is a fragment."""
TOUCHING_SD = np.array([0.007, 0.007, 0.001])
"""What a neighbour adds to the standard deviation of width, depth and height, metres: an edge that it hides is taken for seen.

Learned: with it 90 % of the intervals of touching boxes held on simulated development scenes (``simulated(6, 7)``).
"""
SUPPORT_BAND = 0.01
"""Pixels this near to the plane that a box stands on show its support, metres."""


def objects(scene: OnFloor, masks: list[Mask]) -> list[Outcome]:
    """Return what the connected objects of a scan are; one that is no box is tried together with what lies beside it."""
    outcomes = [_object(scene, own) for own in masks]
    for k, own in enumerate(masks):
        if _returns(outcomes[k]) == 0 and (near := beside(own, masks)):
            pooled = np.logical_or.reduce([own, *(masks[other] for other in near)])
            plain = [one for other in (k, *near) for one in outcomes[other]]
            outcomes[k] = _better(_stack(scene, pooled, _parts(scene, pooled)), plain, pooled)
            for other in near:
                outcomes[other] = []
    return [one for several in outcomes for one in several]


def _object(scene: OnFloor, own: Mask) -> list[Outcome]:
    """Return what one connected object is: a box, a box and what is left beside it, or where that explains more, a stack."""
    outcomes: list[Outcome] = []
    queue = [(own, False)]
    while queue and len(outcomes) < MAX_OBJECTS:
        part, split_off = queue.pop(0)
        result, parts = single(scene, part, touching=split_off)
        queue += [(rest, True) for rest in parts]
        outcomes.append(Outcome(_bounded(result) if split_off or parts else result, part))
    if len(outcomes) == 1 and not _doubtful(outcomes[0].result):
        return outcomes
    pieces = _parts(scene, own)
    if sum(len(piece.pixels) for piece in pieces if piece.curved) > MAX_CURVED * own.sum():
        return [Outcome(Refusal("not_a_box"), own)]
    return _better(_stack(scene, own, pieces), outcomes, own)


def _better(stacked: list[Outcome], plain: list[Outcome], own: Mask) -> list[Outcome]:
    """Return the reading of an object as a stack if it explains most of the object, and more than the plain reading does."""
    explained = _returns(stacked)
    needed = MIN_STACK_SHARE if _returns(plain) else MIN_STACK_SHARE_ALONE
    enough = explained > needed * own.sum() and explained > STACK_GAIN * _returns(plain)
    return stacked if enough else plain


def _bounded(result: BoxEstimate | Refusal) -> BoxEstimate | Refusal:
    """Return a part of an object, loosened, or refused where one upright side is all that is seen: any flat thing shows that."""
    if isinstance(result, Refusal):
        return result
    result = loosened(result)
    enough = MIN_SECOND_FACE * result.quality.returns
    seen = [face.name for face in result.quality.faces if face.seen and face.returns >= enough]
    return result if len(seen) > 1 or "top" in seen else Refusal("not_a_box")


def loosened(estimate: BoxEstimate) -> BoxEstimate:
    """Return the estimate of a touching box with what its neighbours add to its uncertainty; open extents stay as they are."""
    covariance = estimate.covariance.copy()
    covariance[range(6, 9), range(6, 9)] += TOUCHING_SD**2
    x, y, z = (_wider(interval, sd) for interval, sd in zip(estimate.intervals, TOUCHING_SD, strict=True))
    return replace(estimate, covariance=covariance, intervals=(x, y, z))


def _wider(interval: Interval, sd: float) -> Interval:
    if not np.isfinite(interval.sigma + interval.high):
        return interval
    sigma = float(np.hypot(interval.sigma, sd))
    more = Z90 * (sigma - interval.sigma)
    return Interval(interval.low - more, interval.high + more, sigma)


def _doubtful(result: BoxEstimate | Refusal) -> bool:
    """Return whether an object is perhaps several: no box, or one that leaves more unexplained than noise would."""
    if isinstance(result, Refusal):
        return result.reason == "not_a_box"
    return "bent" in result.flags or result.quality.explained < SURE_EXPLAINED or result.quality.overlap < SURE_OVERLAP


def _returns(outcomes: list[Outcome]) -> int:
    return sum(one.result.quality.returns for one in outcomes if isinstance(one.result, BoxEstimate))


def _parts(scene: OnFloor, own: Mask) -> list[Group]:
    """Return the boxes-to-be of an object split into flat patches, without fragments."""
    placing = floor_to_camera(scene.floor.plane)
    noise = scene.floor.noise * float(np.median(scene.model.range_sigma(scene.image.ranges[own], np.array(0.7))))
    found = groups(patches(scene.image, own, scene.floor, scene.model, placing), scene.image, noise)
    return [part for part in found if len(part.pixels) >= max(MIN_PIXELS, (1 if part.has_top else 2) * MIN_PART * own.sum())]


def _stack(scene: OnFloor, own: Mask, parts: list[Group]) -> list[Outcome]:
    """Return the boxes that the parts of an object are, each on the floor or on the box beneath it."""
    placing = floor_to_camera(scene.floor.plane)
    masks = [part.mask(own.shape) for part in parts]
    outcomes: list[Outcome] = []
    again: list[tuple[int, Mask, Mask, float]] = []
    for part, mask in zip(parts, masks, strict=True):
        boxes = [one.result.box for one in outcomes if isinstance(one.result, BoxEstimate)]
        if explained_by(boxes, scene.image, mask) > 0.5:
            continue
        if part.tilted or part.curved:
            outcomes.append(Outcome(Refusal("not_a_box" if part.curved else "tilted"), mask))
            continue
        height = support_height(part, boxes, placing)
        others = np.logical_or.reduce([scene.taken & ~own, *(other for other in masks if other is not mask)])
        outcomes.append(Outcome(_on_support(scene, mask, others, height), mask))
        again.append((len(outcomes) - 1, mask, others, height))
    found = [entry for entry in again if isinstance(outcomes[entry[0]].result, BoxEstimate)]
    if len(found) == 1:  # one box after all: what floats beside it may be its flaps
        ((k, mask, others, height),) = found
        outcomes[k] = Outcome(_on_support(scene, mask, others, height, among_boxes=False), mask)
    return _apart(sorted(outcomes, key=lambda one: -int(one.own.sum())))


def _apart(outcomes: list[Outcome]) -> list[Outcome]:
    """Return the outcomes without the boxes that stand within a box of more pixels: two bodies share no room."""
    kept: list[Outcome] = []
    for one in outcomes:
        if isinstance(one.result, BoxEstimate):
            larger = [other.result.box for other in kept if isinstance(other.result, BoxEstimate)]
            if max((shared_room(one.result.box, box) for box in larger), default=0.0) > MAX_SHARED_ROOM:
                one = Outcome(Refusal("not_a_box"), one.own)
        kept.append(one)
    return kept


def _on_support(scene: OnFloor, own: Mask, others: Mask, height: float, *, among_boxes: bool = True) -> BoxEstimate | Refusal:
    """Return the box fitted to one part of a stack that stands at ``height`` above the floor, or the reason against it."""
    image, floor = scene.image, scene.floor
    if height > 0:
        floor = replace(floor, plane=Plane(floor.plane.normal, floor.plane.offset - height), bare=None)
        others = image.valid & ~own & (others | (np.abs(floor.plane.height(image.points)) > 3 * SUPPORT_BAND))
        others &= ~(np.abs(floor.plane.height(image.points)) < SUPPORT_BAND)
    fit = fitted(image, floor, own, others, scene.model, noise_known=scene.noise_known)
    result = _bounded(judged(fit, image, floor, own, touching=True, stacked=among_boxes))
    if height > 0 and isinstance(result, BoxEstimate):
        return replace(result, flags=(*result.flags, "stacked"))
    return result

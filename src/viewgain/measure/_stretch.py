"""A dimension that no seen face spans: the likelihood may peak more than once along it, so the box is fitted at many lengths.

The near face stays where it was seen and the far one moves off; everything else is fitted anew at each length.
"""

import numpy as np

from viewgain.arrays import Array
from viewgain.box import PARAMETERS, Box
from viewgain.geometry import inverse
from viewgain.measure._fit import Fit, View, refine
from viewgain.measure._mixture import Softness
from viewgain.measure._pixels import edges_kept

SPANNING = ((2, 3, 4), (0, 1, 4), (0, 1, 2, 3, 4))
"""The faces that show each axis of the box: those that contain it, and for the height the top, for the floor is known."""
SPANNING_POINTS = 100
"""A face with at least this many returns shows how far it reaches."""
LEVEL = 2.0
"""A log likelihood that falls by less than this, four sigma out, is level: a Gaussian's falls by 8."""
CLEARLY = 10.0
"""How many times as far that of some pixels has to fall for that of all not to be asked."""
FEW_PIXELS = 300
"""How many those are, away from the outline; beside it some more (:func:`viewgain.measure._pixels.edges_kept`)."""
_SIDES = (0, 1)
_STEPS = 2


def returned(view: View) -> View:
    """Return the view without its missing returns.

    A face seen flat and the floor behind it both lose their returns; which of the two a missing one was decides how long the
    box is, and rests on chances of loss that a sensor model knows only roughly.
    """
    return view.with_pixels(view.pixels.take(np.flatnonzero(np.isfinite(view.pixels.ranges))))


def profile(fit: Fit, axis: int, lengths: Array, softness: Softness) -> list[Fit]:
    """Return the fit at each of the ascending (k,) ``lengths`` of an axis, all else refitted, each from its neighbour on."""
    fits = {}
    for outward in (lengths[lengths >= fit.box.extents[axis]], lengths[lengths < fit.box.extents[axis]][::-1]):
        last = fit
        for length in outward:
            start = stretched(last.box, axis, _far_side(fit, axis), float(length))
            last = refine(start, fit.views, (softness,), _STEPS, last.corrections, held=axis)
            fits[float(length)] = last
    return [fits[float(length)] for length in lengths]


def stays_level(fit: Fit, axis: int, length: float, softness: Softness) -> bool:
    """Return whether the log likelihood falls by less than :data:`LEVEL` from a fit to one of another length along an axis.

    Some of the pixels are asked first, those at the outline among them: where theirs alone falls ten times as far, that of all
    does not stay level, since what the others say was already best at the fit.
    """
    few = of_few_pixels(fit, softness)
    return fall(few, axis, length, softness) < CLEARLY * LEVEL and fall(fit, axis, length, softness) < LEVEL


def fall(fit: Fit, axis: int, length: float, softness: Softness) -> float:
    """Return by how much the log likelihood falls from a fit to the one of another length, all else refitted."""
    return fit.value - profile(fit, axis, np.array([length]), softness)[0].value


def of_few_pixels(fit: Fit, softness: Softness) -> Fit:
    """Return the same box beside fewer pixels of its views."""
    views = tuple(
        view.with_pixels(edges_kept(view.pixels, view.sees(fit.box, correction), FEW_PIXELS))
        for view, correction in zip(fit.views, fit.corrections, strict=True)
    )
    return refine(fit.box, views, (softness,), 0, fit.corrections)


def stretched(box: Box, axis: int, side: float, length: float) -> Box:
    """Return the box with another length along an axis, whose end at ``side`` (-1 or 1) moves and whose other end stays.

    The vertical axis stays on the floor.
    """
    step = np.zeros(PARAMETERS)
    step[6 + axis] = length - box.extents[axis]
    if axis in _SIDES:
        step[3 + axis] = side * step[6 + axis] / 2
    return box.moved(step)


def _far_side(fit: Fit, axis: int) -> float:
    """Return the end of an axis with fewer readings on its face; where that is equal, the end away from the camera."""
    if axis not in _SIDES:
        return 1.0
    plus, minus = np.sum([evaluation.readings for evaluation in fit.evaluations], axis=0)[2 * axis : 2 * axis + 2]
    if plus != minus:
        return 1.0 if plus < minus else -1.0
    return -1.0 if inverse(fit.box.box_to_camera)[axis, 3] > 0 else 1.0

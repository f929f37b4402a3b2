"""What one view is expected to show of a box: information about it, and which of its dimensions can be seen from end to end."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Mask, Pose
from viewgain.box import FACES, Box, edges_shown
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.measure import MIN_EDGE_SHOWN, SPANNING, SPANNING_POINTS, Knowledge
from viewgain.plan._predict import predict, to_pixels

_ENDS = ((0, 1), (2, 3), (4,))
"""The faces at the ends of each axis of the box, except the bottom."""


@dataclass(frozen=True, slots=True, eq=False)
class Showing:
    """What a camera at a pose would show of a box."""

    knowledge: Knowledge
    """Expected information and systematic gradient, box frame."""
    spanned: Mask
    """(3,) axes of the box that faces with many returns show from end to end, as in measuring."""
    cut: bool
    """Whether the box leaves the image."""
    returns: float
    """Expected number of returns from it."""


def showing(box: Box, camera_to_current: Pose, sensor: Sensor, noise: float) -> Showing:
    """Return what ``sensor`` at a pose would show of ``box``; arguments as :func:`viewgain.plan.predict`."""
    predicted = predict(box, camera_to_current, sensor, noise)
    returns = np.zeros(len(FACES))
    for sight in predicted.sights:
        returns[FACES.index(sight.name)] = sight.returns
    if not predicted.sights:
        return Showing(predicted.knowledge, np.zeros(3, dtype=bool), predicted.cut, 0.0)
    camera = sensor.intrinsics
    seen = box.in_frame(inverse(camera_to_current))
    shown = edges_shown(seen, to_pixels(camera), (camera.width, camera.height)) >= MIN_EDGE_SHOWN
    spanned = np.zeros(3, dtype=bool)
    for axis, ends in enumerate(_ENDS):
        along = [face for face in SPANNING[axis] if returns[face] >= SPANNING_POINTS]
        spanned[axis] = bool(along) and all(returns[end] >= SPANNING_POINTS or shown[along, end].any() for end in ends)
    return Showing(predicted.knowledge, spanned, predicted.cut, float(returns.sum()))

"""From a whole scan to the points that a sample keeps."""

import numpy as np

from viewgain.arrays import Points
from viewgain.datasets._sample import drawn
from viewgain.datasets._settings import PointRules


def kept(points: Points, rules: PointRules, *, rng: np.random.Generator) -> Points:
    """Return the points of a sample, in the order of the scan: as many as the rules ask for, drawn at random.

    ``rng`` is used only where points have to be drawn.
    """
    if rules.resample:
        return points[drawn(len(points), rules.resample, rng=rng)]
    if len(points) > rules.cap:
        return points[drawn(len(points), rules.cap, rng=rng)]
    return points

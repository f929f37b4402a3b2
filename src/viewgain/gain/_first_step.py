"""The first step of the published rule from every first view at once.

From a first view s, a point is new unless it is near a point of view s. So the set of all views that have a point near it, one
number of 64 bits, says of every point from which first views it is new, and one pass over the points serves them all.
"""

import numpy as np

from viewgain.gain._bits import Counts
from viewgain.gain._cover import Cover
from viewgain.gain._near import near_marks
from viewgain.gain._pairs import join

MOST_VIEWS = 64
"""Bits of a number."""


def first_gains(covered: Cover) -> Counts:
    """Return the (V, V) numbers of samples that each view (column) adds to each first view (row); V <= 64."""
    views, bits = covered.view_of_point, np.uint64(1) << np.arange(covered.views, dtype=np.uint64)
    new_from = ~near_marks(covered.points, bits[views], covered.reach, search=covered.search)
    reached = join(covered.pairs, new_from, views, covered.counts.shape, search=covered.search)
    return np.array([np.count_nonzero(reached & bit, axis=1) for bit in bits])

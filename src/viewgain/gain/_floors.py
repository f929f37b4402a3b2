"""What choices without any learning get: a uniform guess, and always the same number of views on."""

import numpy as np
from numpy.typing import ArrayLike

from viewgain.arrays import Array
from viewgain.errors import DataError
from viewgain.gain._choices import hits, only_free


def uniform_hits(gains: ArrayLike, free: ArrayLike | None = None) -> Array:
    """Return (N, 5) how probably a view drawn uniformly from the free ones is within each limit; exact, nothing is drawn.

    Args:
        gains: (N, V) share of the surface that each view adds.
        free: (N, V) views that may be chosen; None for all.

    Raises:
        ConfigError: If a sample has no free view.
    """
    allowed = only_free(gains, free)
    within = hits(allowed.max(axis=1, keepdims=True) - allowed)
    chances: Array = within.sum(axis=1) / np.isfinite(allowed).sum(axis=1)[:, None]
    return chances


def constant_offset(gains: ArrayLike, free: ArrayLike | None = None) -> int:
    """Return the offset from the present view that is best most often; choose it on training samples.

    Args:
        gains: (N, V) share of the surface that each view adds, present view first.
        free: (N, V) views that may be chosen; None for all.

    Raises:
        DataError: If there are no samples.
        ConfigError: If a sample has no free view.
    """
    allowed = only_free(gains, free)
    if len(allowed) == 0:
        raise DataError("choice: got no training samples, wanted some to choose the constant answer on")
    best = hits(allowed.max(axis=1, keepdims=True) - allowed)[..., 0]
    return int(np.argmax(best.sum(axis=0)))

"""Circular permutation: scores in rig order, turned so that the present view comes first, and back. Source paper, section 3.

A network that never learns where it stands can learn the turned scores: entry k is then "k stations on from here".
"""

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ConfigError


def rolled(scores: Array, view: int) -> Array:
    """Return (..., V) scores with that of ``view`` first, the rig's order kept: ``np.roll(scores, -view)`` along the last axis.

    Args:
        scores: (..., V) one score per station, in rig order.
        view: The present station, 0 to V - 1.

    Raises:
        ConfigError: If there is no such station.
    """
    _require_view(scores, view)
    return np.roll(scores, -view, axis=-1)


def unrolled(scores: Array, view: int) -> Array:
    """Return (..., V) scores back in rig order, the inverse of :func:`rolled`; raises as it does."""
    _require_view(scores, view)
    return np.roll(scores, view, axis=-1)


def _require_view(scores: Array, view: int) -> None:
    count = np.shape(scores)[-1] if np.ndim(scores) else 0
    if not 0 <= view < count:
        raise ConfigError(f"permutation: got view {view} of {count}, wanted one from 0 to {count - 1}")

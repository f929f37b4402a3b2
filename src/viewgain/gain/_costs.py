"""What a scan costs whoever wanted the volume from it: its error, and all of the volume where it gives none (ours)."""

import numpy as np
from numpy.typing import ArrayLike

from viewgain.arrays import Array

MISS = 1.0
"""What a scan without an estimate costs, and the most that any scan does: all of the volume."""


def costs(errors: ArrayLike) -> Array:
    """Return what scans cost: min(|error|, 1) of relative volume errors of any shape; 1 for what is not finite (a miss)."""
    table = np.abs(np.asarray(errors, dtype=float))
    return np.where(np.isfinite(table), np.minimum(table, MISS), MISS)

"""Metres or millimetres: the one rule, stated in docs/formats.md and said in every scan's notes."""

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ConfigError

MILLIMETRES_FROM = 20.0
"""A median distance above this is read as millimetres: no box scan is 20 m away, and none is 20 mm away."""

METRES_PER_UNIT = {"m": 1.0, "mm": 0.001}
_NAMES = {"m": "metres", "mm": "millimetres"}


def metres_per_unit(points: Array, units: str | None, scale: float | None, scale_note: str) -> tuple[float, str]:
    """Return how many metres one unit of (..., 3) ``points`` is, and the sentence that says why.

    Args:
        points: Points in the file's units; returns that are not finite or at the origin are left out.
        units: "m" or "mm" as the caller ordered, which beats everything; None lets the file or the rule decide.
        scale: Metres per unit where the file says it.
        scale_note: Where ``scale`` comes from.

    Returns:
        The factor and the note; without valid points the factor is 1.

    Raises:
        ConfigError: If ``units`` is neither "m" nor "mm".
    """
    if units is not None:
        if units not in METRES_PER_UNIT:
            raise ConfigError(f"units: got {units!r}, wanted 'm' or 'mm' (or leave it out to have them detected)")
        return METRES_PER_UNIT[units], f"units: {_NAMES[units]}, as ordered"
    if scale is not None:
        return scale, f"units: {scale_note}"
    distances = np.linalg.norm(points.reshape(-1, 3), axis=1)
    distances = distances[np.isfinite(distances) & (distances > 0)]
    if len(distances) == 0:
        return 1.0, "units: unknown, there are no valid points"
    median = float(np.median(distances))
    units = "mm" if median > MILLIMETRES_FROM else "m"
    return METRES_PER_UNIT[units], f"units: read as {_NAMES[units]} (median distance {median:.4g})"

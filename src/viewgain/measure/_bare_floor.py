"""What a scan of the empty scene says about the floor, for a scan whose object hides it or where it gives nothing back."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask, Points
from viewgain.geometry import Plane
from viewgain.measure._range_image import RangeImage

OWN_FLOOR = 0.2
"""A scan of which a smaller share lies on the floor leaves saying where it is to the scan of the empty scene."""
_MOST = 1000
"""How many readings of the empty scene say so, at most."""
_SPREADS = 3.0
"""What lies within so many spreads of the plane is on it."""


@dataclass(frozen=True, slots=True, eq=False)
class BareFloor:
    """Readings of the floor without anything on it, from where the scan was taken."""

    directions: Points
    """(m, 3) unit rays, camera frame."""
    ranges: Array
    """(m,) measured range, metres."""


def bare_floor(plane: Plane, spread: float, empty: RangeImage, scan: RangeImage) -> BareFloor | None:
    """Return the readings of a floor in an empty scene; None if the scan itself shows enough of it.

    Args:
        plane: The floor as found in the empty scene, camera frame.
        spread: Standard deviation of its points about it, metres.
        empty: The scan of the empty scene.
        scan: The scan that is measured, from the same pose.
    """
    reach = _SPREADS * spread
    if _near(plane, reach, scan).sum() >= OWN_FLOOR * scan.valid.sum():
        return None
    at = np.flatnonzero(_near(plane, reach, empty))
    at = at[:: max(1, len(at) // _MOST)]
    return BareFloor(empty.directions.reshape(-1, 3)[at], empty.ranges.ravel()[at])


def _near(plane: Plane, reach: float, image: RangeImage) -> Mask:
    """Return the (h, w) pixels with a return within ``reach`` of a plane."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(plane.height(image.points)) < reach)

"""The lathe: a profile turned about the z axis."""

from collections.abc import Sequence

import numpy as np

from viewgain.arrays import Array, Points2
from viewgain.errors import ConfigError
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part, loop_skin, skin

Profile = Points2 | Sequence[tuple[float, float]]
"""(k, 2) radius and height along a line that keeps the material on its left: out from the axis, up, and in again."""


def lathe(profile: Profile, sides: int = 24) -> Part:
    """Return the solid that a profile sweeps about the z axis; an end that is not on the axis is closed by a flat disc.

    Raises:
        ConfigError: If a radius is negative, or zero anywhere but at an end.
    """
    line = np.asarray(profile, dtype=float)
    first, last = int(line[0, 0] == 0), len(line) - int(line[-1, 0] == 0)
    inner = line[first:last]
    if len(inner) == 0 or inner[:, 0].min() <= 0:
        raise ConfigError("a lathe profile touches the axis between its ends; keep its radii positive there")
    return skin(_rings(inner, sides), np.array([0.0, 0.0, line[0, 1]]), np.array([0.0, 0.0, line[-1, 1]]))


def lathe_ring(profile: Profile, sides: int = 24) -> Part:
    """Return the ring that a closed profile sweeps about the z axis, clear of the axis.

    Raises:
        ConfigError: If the profile reaches the axis.
    """
    line = np.asarray(profile, dtype=float)
    if line[:, 0].min() <= 0:
        raise ConfigError("the profile of a ring reaches the axis; keep its radii positive")
    return loop_skin(_rings(line, sides))


def hollow(outer: Profile, wall: float, floor: float) -> Points2:
    """Return the profile of an open vessel from that of its outside, which rises from the foot to the rim.

    Args:
        outer: Outside, heights increasing, radii positive.
        wall: Thickness of the wall; at most half of the radius is taken.
        floor: Thickness of the bottom.
    """
    line = np.asarray(outer, dtype=float)
    bottom = line[0, 1] + floor
    inside = np.empty(((line[:, 1] > bottom + 0.05 * floor).sum() + 1, 2))
    inside[:-1] = line[: -len(inside) : -1]
    inside[-1] = np.interp(bottom, line[:, 1], line[:, 0]), bottom
    inside[:, 0] = np.maximum(inside[:, 0] - wall, inside[:, 0] / 2)
    return np.concatenate([line, inside, [[0.0, bottom]]])


def _rings(profile: Points2, sides: int) -> Array:
    """Return (k, sides, 3) circles of the profile's radii at its heights."""
    rings = np.empty((len(profile), sides, 3))
    rings[:, :, :2] = profile[:, None, :1] * unit_circle(sides)
    rings[:, :, 2] = profile[:, 1:]
    return rings

"""Handles of vessels."""

from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import smooth
from viewgain.shapes._sweep import sweep


def ear(points: list[tuple[float, float]], radius: float, flat: float = 1.0) -> Part:
    """Return a handle through points given as (distance behind the axis, height)."""
    path = smooth([(-x, 0.0, z) for x, z in points], 6 * len(points))
    return sweep(path, unit_circle(10) * (radius * flat, radius))

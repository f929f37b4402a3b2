"""The light that comes back to each pixel, before anything random happens to it."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Vector
from viewgain.camera import Sensor
from viewgain.rays import Hits, Surfaces

LONGEST_WAVE = 100.0
"""A wave longer than any scene, metres: phases then add like ranges weighted by amplitude."""


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """What each of n pixels receives."""

    ranges: Vector
    """(n,) range that its phase says, metres; inf where nothing comes back."""
    amplitude: Vector
    """(n,) strength; a white surface seen head-on at 1 m gives one."""
    cosine: Vector
    """(n,) cosine of incidence on what it sees; where it sees several surfaces, their mean weighted by amplitude."""
    reflectivity: Vector
    """(n,) share of light given back, weighted likewise."""


def direct_signal(hits: Hits, surfaces: Surfaces) -> Signal:
    """Return the signal of pixels that look through their centres only: a Lambertian surface lit from the camera."""
    reflectivity = surfaces.reflectivity[hits.surfaces]
    return Signal(hits.ranges, lambertian(hits, reflectivity), hits.cosine, reflectivity)


def lambertian(hits: Hits, reflectivity: Array) -> Vector:
    """Return reflectivity * cos(incidence) / range^2; 0 for nothing."""
    return np.asarray(reflectivity * hits.cosine / np.square(hits.ranges))


def mixing_wavelength(sensor: Sensor) -> float:
    """Return the metres of range per turn of phase within which signals add up."""
    return min(sensor.wavelength, LONGEST_WAVE)

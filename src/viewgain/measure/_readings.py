"""Range readings on one surface: what a weighted least squares fit of the box has of them."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Points
from viewgain.box import Box, Hits, floor_hits
from viewgain.camera import Sensor
from viewgain.measure._bare_floor import BareFloor
from viewgain.measure._mixture import FAR, Mixture, Pixels, Softness, Surface

_NEGLIGIBLE = 1e-3
"""Readings that belong to the surface with less than this probability are left out."""


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """The range readings on one surface."""

    directions: Points
    """(m, 3) unit rays."""
    hits: Hits
    """Where they meet it."""
    ranges: Array
    """(m,) measured, metres."""
    precision: Array
    """(m,) responsibility over sigma squared."""
    misfit: Array
    """(m,) measured minus predicted, metres."""

    @property
    def log_density(self) -> float:
        """Log of their joint density were they all of this surface, up to a constant."""
        return 0.5 * float(np.log(self.precision).sum() - self.precision @ self.misfit**2)


def shown_readings(pixels: Pixels, sensor: Sensor, mixture: Mixture) -> tuple[Readings, Readings]:
    """Return the readings on the faces and on the floor.

    A face that should have lost a return did not give it: so far what it reports was mixed in from elsewhere.
    """
    kept = mixture.on_box * (1 - sensor.loss(mixture.box.hits.cosine))
    return _readings_on(pixels, mixture.box, kept, np.inf), _readings_on(pixels, mixture.floor, mixture.on_floor, pixels.horizon)


def bare_readings(box: Box, bare: BareFloor, sensor: Sensor, noise: float, softness: Softness) -> Readings:
    """Return the readings of the bare floor; rays that would miss it have something to lose."""
    hits = floor_hits(box, bare.directions)
    predicted = np.minimum(hits.ranges, FAR)
    sigma = np.hypot(noise * sensor.range_sigma(np.minimum(predicted, 10.0), hits.cosine), softness.extra_sigma)
    return Readings(bare.directions, Hits(predicted, hits.planes, hits.cosine), bare.ranges, sigma**-2, bare.ranges - predicted)


def _readings_on(pixels: Pixels, surface: Surface, probability: Array, horizon: float) -> Readings:
    """Return the range readings on one surface.

    Readings near the ``horizon`` are left out: beyond it nothing comes back, so of those just before it only the short ones
    do, and they would tilt the floor.
    """
    responsibility = probability * surface.gauss
    used = np.flatnonzero((responsibility > _NEGLIGIBLE) & (surface.hits.ranges < horizon - 4 * surface.sigma))
    at, sigma = surface.at[used], surface.sigma[used]
    precision, misfit = responsibility[used] / sigma**2, surface.z[used] * sigma
    return Readings(pixels.directions[at], surface.hits.take(used), pixels.ranges[at], precision, misfit)

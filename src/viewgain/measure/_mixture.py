"""What did each pixel see, the box or what lies beside it? The mixture at the heart of the likelihood.

A pixel's ray sees the box with probability Phi(s / w), where s is its signed distance to the box's outline in pixels and w the
blur, and the floor (or clutter) otherwise. Each has a density for the range that comes back and a chance that none does; on the
outline itself a pixel may also mix the two. Where floor and face have the same range the mixture cannot tell them apart, so the
contact line says nothing about the outline, by itself (ours).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from viewgain.arrays import Array, Indices, Mask, Points, Points2
from viewgain.box import Box, EdgeDistances, Hits, Outline, box_hits, edge_distances, floor_hits, outline
from viewgain.camera import Sensor

STRAY = 0.02
"""Share of returns from the box that are nowhere near it (multipath, crosstalk)."""
CLUTTER = 0.10
"""Share of rays beside the box that meet something other than the floor."""
SPAN = 3.0
"""Stray and clutter returns are uniform over this many metres."""
FLYING = 0.3
"""Share of mixed pixels on the outline itself."""
FLYING_REACH = 1.2
"""How far from the outline pixels mix, pixels: their share falls off as exp(-(s / reach)^4 / 2), at two pixels to nothing."""
LOST_NEAR = (0.02, 0.96)
"""Chance that a face brings nothing back: at head-on incidence, and what the sensor's grazing loss adds at most."""
LOST_FAR = (0.05, 0.90)
"""The same for the floor."""
LOST_BEYOND = 0.9
"""Chance that the floor brings nothing back from beyond the farthest return of the scan."""
HORIZON_BLUR = 0.03
"""How gradually that sets in, as a share of the farthest range."""


@dataclass(frozen=True, slots=True, eq=False)
class Pixels:
    """The pixels that speak about one box."""

    directions: Points
    """(n, 3) unit rays, camera frame."""
    image: Points2
    """(n, 2) the same rays in normalised image coordinates."""
    ranges: Array
    """(n,) measured range, metres; NaN for a missing return."""
    other: Mask
    """(n,) pixels that belong to another object."""
    weight: Array
    """(n,) how many pixels each stands for, where they were thinned; for counting only: a pixel left out gives no information."""
    pitch: float
    """Pixel size in normalised image coordinates."""
    horizon: float
    """Range beyond which this scan has no returns, metres."""

    def take(self, chosen: Indices, weight: Array | None = None) -> "Pixels":
        """Return a subset, optionally with other weights."""
        weights = self.weight[chosen] if weight is None else weight
        return Pixels(
            self.directions[chosen],
            self.image[chosen],
            self.ranges[chosen],
            self.other[chosen],
            weights,
            self.pitch,
            self.horizon,
        )


@dataclass(frozen=True, slots=True)
class Softness:
    """How sharply the fit looks: wide at first, so that it sees edges from afar, then as sharp as the camera."""

    edge: float
    """Blur of the outline, pixels."""
    extra_sigma: float = 0.0
    """Added to the range noise, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """One of the two things a pixel may have seen: where its ray meets it, and how well the range agrees."""

    hits: Hits
    """Where the rays meet the surface."""
    sigma: Array
    """(n,) standard deviation of the range, metres."""
    z: Array
    """(n,) measured minus predicted range over sigma; NaN for a missing return."""
    gauss: Array
    """(n,) share of the density below that the surface itself explains (not strays)."""
    density: Array
    """(n,) density of what the pixel reported, a range or nothing, had it seen this surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Mixture:
    """The two surfaces, the outline between them, and what each pixel was taken for."""

    box: Surface
    """The box's faces."""
    floor: Surface
    """The floor."""
    shape: Outline
    """The box's outline."""
    edges: EdgeDistances
    """Each pixel's place relative to it."""
    inside: Array
    """(n,) signed distance to the outline, pixels, positive inside."""
    on_box: Array
    """(n,) probability that the pixel saw the box."""
    on_floor: Array
    """(n,) probability that it saw what lies beside."""
    on_both: Array
    """(n,) probability that it mixed the two."""
    could_mix: Array
    """(n,) what that probability would be had it reported what an unmixed pixel does."""
    value: float
    """Log likelihood of all pixels, up to a constant."""


def mix(box: Box, pixels: Pixels, sensor: Sensor, noise: float, softness: Softness) -> Mixture:
    """Return what each pixel was taken for, and the log likelihood of them all.

    Args:
        box: The hypothesis, with its floor.
        pixels: What the camera saw.
        sensor: Gives the shape of the noise over range and incidence, and of grazing loss.
        noise: Factor on the sensor's noise, as estimated from this scan.
        softness: Blur of outline and range.
    """
    shape = outline(box)
    edges = edge_distances(shape, pixels.image)
    inside = edges.distance / pixels.pitch
    faces, ground = box_hits(box, pixels.directions), floor_hits(box, pixels.directions)
    beyond = ndtr((np.minimum(ground.ranges, 1e3) / pixels.horizon - 1) / HORIZON_BLUR)
    lost_near = LOST_NEAR[0] + LOST_NEAR[1] * sensor.loss(faces.cosine)
    lost_floor = LOST_FAR[0] + LOST_FAR[1] * sensor.loss(ground.cosine)
    lost_far = lost_floor + beyond * np.maximum(LOST_BEYOND - lost_floor, 0.0)
    near = _surface(pixels, faces, sensor, noise, softness, lost_near, STRAY)
    far = _surface(pixels, ground, sensor, noise, softness, lost_far, CLUTTER)
    near, far = _with_other_objects(pixels, near, far)

    seen, unseen = ndtr(inside / softness.edge), ndtr(-inside / softness.edge)
    mixing = FLYING * np.exp(-0.5 * (inside / FLYING_REACH) ** 4)
    pure = seen * near.density + unseen * far.density
    mixed = _mixed_density(pixels, near, far)
    total = np.maximum((1 - mixing) * pure + mixing * mixed, 1e-12)
    share = (1 - mixing) / total
    on_box, on_floor = share * seen * near.density, share * unseen * far.density
    return Mixture(
        near,
        far,
        shape,
        edges,
        inside,
        on_box,
        on_floor,
        mixing * mixed / total,
        mixing * pure / total,
        float(np.sum(np.log(total))),
    )


def _surface(pixels: Pixels, hits: Hits, sensor: Sensor, noise: float, softness: Softness, lost: Array, stray: float) -> Surface:
    """Return one surface's density: a Gaussian about its range, uniform strays, and the chance of no return."""
    predicted = np.minimum(hits.ranges, 1e3)
    sigma = np.hypot(noise * sensor.range_sigma(np.minimum(predicted, 10.0), hits.cosine), softness.extra_sigma)
    z = (pixels.ranges - predicted) / sigma
    missing = np.isnan(z)
    peak = (1 - stray) * np.exp(-0.5 * np.where(missing, np.inf, z * z)) / (np.sqrt(2 * np.pi) * sigma)
    density = np.where(missing, lost, (1 - lost) * (peak + stray / SPAN))
    return Surface(hits, sigma, z, peak / (peak + stray / SPAN), density)


def _with_other_objects(pixels: Pixels, near: Surface, far: Surface) -> tuple[Surface, Surface]:
    """Return the surfaces knowing which pixels saw another object: beside the box it replaces the floor, before it hides both."""
    if not pixels.other.any():
        return near, far
    beside = np.where(pixels.other, 1 / SPAN, far.density)
    hidden = pixels.other & (pixels.ranges < near.hits.ranges)
    before = np.where(hidden, beside, near.density)
    return (
        Surface(near.hits, near.sigma, near.z, np.where(hidden, 0.0, near.gauss), before),
        Surface(far.hits, far.sigma, far.z, np.where(pixels.other, 0.0, far.gauss), beside),
    )


def _mixed_density(pixels: Pixels, near: Surface, far: Surface) -> Array:
    """Return the (n,) density of a mixed pixel: uniform between the surfaces, blurred by the noise; an even chance of nothing."""
    low = np.minimum(near.hits.ranges, far.hits.ranges)
    high = np.clip(np.maximum(near.hits.ranges, far.hits.ranges), low, np.maximum(low, SPAN))
    between = ndtr((pixels.ranges - low) / near.sigma) * ndtr((high - pixels.ranges) / near.sigma)
    density = between / np.maximum(high - low, 2 * near.sigma) + 0.05 / SPAN
    return np.where(np.isnan(pixels.ranges), 0.5, density)

"""The likelihood of a range image given a box on a floor: every pixel votes with its range and with what it hit.

A pixel's ray sees the box with probability Phi(s / w), where s is its signed distance to the box's outline in pixels and w the
softness of the pixel, and the floor otherwise. So edges are located by which pixels hit and which miss, along their whole
length, and faces by all their points, in one smooth function (ours). Far from the outline it is least squares; where floor and
face have the same range (the contact line) it knows by itself that the outline says nothing.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtr

from viewgain.arrays import Array, Mask, Points, Points2
from viewgain.box import Box, Hits, box_hits, edge_distances, edge_jacobian, floor_hits, outline, range_jacobian
from viewgain.camera import Sensor

STRAY = 0.02
"""Share of returns from the box that are nowhere near it (multipath, crosstalk)."""
CLUTTER = 0.10
"""Share of rays beside the box that meet something other than the floor."""
SPAN = 3.0
"""Stray returns are uniform over this many metres."""
FLYING = 0.3
"""Share of mixed pixels on the outline itself; falls off within about a pixel and a half."""
_EDGE_REACH = 30.0


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

    def take(self, chosen: Array, weight: Array | None = None) -> "Pixels":
        """Return a subset, optionally with other weights."""
        weights = self.weight[chosen] if weight is None else weight
        return Pixels(
            self.directions[chosen], self.image[chosen], self.ranges[chosen], self.other[chosen], weights, self.pitch, self.horizon
        )


@dataclass(frozen=True, slots=True)
class Softness:
    """How sharply the fit looks: wide at first, so that it sees edges from afar, then as sharp as the camera."""

    edge: float
    """Blur of the outline, pixels."""
    extra_sigma: float = 0.0
    """Added to the range noise, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Value and derivatives of the log likelihood at one box, and what each pixel was taken for."""

    value: float
    """Log likelihood, up to a constant."""
    gradient: Array
    """(9,) its derivative with respect to a step of the box."""
    information: Array
    """(9, 9) its negative curvature (positive semi-definite approximation)."""
    on_box: Array
    """(n,) probability that the pixel saw the box."""
    inside: Array
    """(n,) signed distance to the outline, pixels, positive inside."""
    residual: Array
    """(n,) measured minus predicted range over its sigma, for what the pixel more probably saw; NaN for missing returns."""
    hits: Hits
    """Where the rays meet the box."""
    systematic: Array
    """(9, 2) gradient caused by a unit relative scale error and by a unit offset (metre) of all ranges."""
    edge_pull: Array
    """(k, 9) gradient caused by each edge of the outline being shown one pixel too far out."""
    edge_precision: Array
    """(k,) information about where each edge of the outline lies, per square pixel."""


def evaluate(box: Box, pixels: Pixels, sensor: Sensor, noise: float, softness: Softness) -> Evaluation:
    """Return the log likelihood of ``pixels`` given ``box``, with its gradient and information.

    Args:
        box: The hypothesis, with its floor.
        pixels: What the camera saw.
        sensor: Gives the shape of the noise over range and incidence, and of grazing loss.
        noise: Factor on the sensor's noise, as estimated from this scan.
        softness: Blur of outline and range.
    """
    hits, floor = box_hits(box, pixels.directions), floor_hits(box, pixels.directions)
    shape = outline(box)
    edges = edge_distances(shape, pixels.image)
    inside = edges.distance / pixels.pitch
    near, far = _density(pixels, hits, sensor, noise, softness), _density(pixels, floor, sensor, noise, softness)

    x = inside / softness.edge
    miss = np.isnan(pixels.ranges)
    mixing = FLYING * np.exp(-0.5 * inside**2)
    blend = _between(pixels.ranges, hits.ranges, floor.ranges, near.sigma)
    lost_near, lost_far = _loss(pixels, hits, floor, sensor)
    in_density = np.where(miss, lost_near, (1 - lost_near) * ((1 - STRAY) * near.gauss + STRAY / SPAN))
    out_density = np.where(miss, lost_far, (1 - lost_far) * ((1 - CLUTTER) * far.gauss + CLUTTER / SPAN))
    occluded = pixels.other & (pixels.ranges < hits.ranges)
    out_density = np.where(pixels.other, 1 / SPAN, out_density)
    in_density = np.where(occluded, out_density, in_density)
    mixture = ndtr(x) * in_density + ndtr(-x) * out_density
    density = np.where(miss, (1 - mixing) * mixture + mixing * 0.5, (1 - mixing) * mixture + mixing * blend)
    density = np.maximum(density, 1e-12)

    share = (1 - mixing) / density
    on_box = share * ndtr(x) * in_density
    on_floor = share * ndtr(-x) * out_density
    face_pull = _pull(on_box, near, (1 - STRAY) * (1 - lost_near), in_density, miss | occluded)
    truncated = floor.ranges > pixels.horizon - 4 * far.sigma
    floor_pull = _pull(on_floor, far, (1 - CLUTTER) * (1 - lost_far), out_density, miss | pixels.other | truncated)
    face_jacobian = range_jacobian(box, pixels.directions[face_pull.used], hits.take(face_pull.used))
    floor_jacobian = range_jacobian(box, pixels.directions[floor_pull.used], floor.take(floor_pull.used))
    at_edge = np.flatnonzero(np.abs(x) < _EDGE_REACH)
    edge_slope, edge_curvature = _edge_terms(x[at_edge], on_box[at_edge], on_floor[at_edge], softness.edge)
    edge_rows = edge_jacobian(box, shape, edges.take(at_edge)) / pixels.pitch

    gradient = face_jacobian.T @ face_pull.slope[face_pull.used] + floor_jacobian.T @ floor_pull.slope[floor_pull.used]
    gradient += edge_rows.T @ edge_slope
    information = (face_jacobian.T * face_pull.weight[face_pull.used]) @ face_jacobian
    information += (floor_jacobian.T * floor_pull.weight[floor_pull.used]) @ floor_jacobian
    information += (edge_rows.T * edge_curvature) @ edge_rows
    scale_and_offset = np.stack([pixels.ranges, np.ones(len(pixels.ranges))], axis=1)
    systematic = (face_jacobian.T * face_pull.weight[face_pull.used]) @ scale_and_offset[face_pull.used]
    systematic += (floor_jacobian.T * floor_pull.weight[floor_pull.used]) @ scale_and_offset[floor_pull.used]
    which = edges.edge[at_edge]
    edge_pull = np.array([(edge_rows * edge_curvature[:, None])[which == k].sum(axis=0) for k in range(len(shape.vertices))])
    edge_precision = np.bincount(which, edge_curvature, minlength=len(shape.vertices))
    probability = on_box / np.maximum(on_box + on_floor, 1e-300)
    residual = np.where(probability > 0.5, near.z, far.z)
    return Evaluation(
        float(np.sum(np.log(density))), gradient, information, probability, inside, residual, hits, systematic, edge_pull, edge_precision
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Density:
    gauss: Array
    sigma: Array
    z: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Pull:
    used: Array
    weight: Array
    slope: Array


def _density(pixels: Pixels, hits: Hits, sensor: Sensor, noise: float, softness: Softness) -> _Density:
    finite = np.where(np.isfinite(hits.ranges), hits.ranges, 1e3)
    sigma = np.hypot(noise * sensor.range_sigma(np.minimum(finite, 10.0), hits.cosine), softness.extra_sigma)
    z = (pixels.ranges - finite) / sigma
    gauss = np.where(np.isnan(z), 0.0, np.exp(-0.5 * np.minimum(np.nan_to_num(z) ** 2, 1400.0)) / (2.5066282746 * sigma))
    return _Density(gauss, sigma, z)


def _between(ranges: Array, near: Array, far: Array, sigma: Array) -> Array:
    """Return the (n,) density of a mixed pixel: uniform between the two surfaces, with a margin of two sigma."""
    low, high = np.minimum(near, far) - 2 * sigma, np.minimum(np.maximum(near, far), SPAN) + 2 * sigma
    with np.errstate(invalid="ignore"):
        return np.where((ranges > low) & (ranges < high), 1 / np.maximum(high - low, 1e-6), 0.05 / SPAN)


def _loss(pixels: Pixels, hits: Hits, floor: Hits, sensor: Sensor) -> tuple[Array, Array]:
    """Return the (n,) probabilities that a ray brings nothing back, if it saw the box, and if it did not."""
    near = 0.02 + 0.96 * sensor.loss(hits.cosine)
    far = np.where(floor.ranges > pixels.horizon, 0.9, 0.05 + 0.9 * sensor.loss(floor.cosine))
    return near, far


def _pull(share: Array, density: _Density, gauss_weight: Array, total: Array, skip: Mask) -> _Pull:
    """Return how strongly each pixel pulls on its surface: responsibility over sigma squared, and that times the residual."""
    with np.errstate(invalid="ignore", divide="ignore"):
        responsibility = np.where(skip, 0.0, share * gauss_weight * density.gauss / np.maximum(total, 1e-300))
    responsibility = np.nan_to_num(responsibility)
    weight = responsibility / density.sigma**2
    slope = responsibility * np.nan_to_num(density.z) / density.sigma
    return _Pull(np.flatnonzero(responsibility > 1e-3), weight, slope)


def _edge_terms(x: Array, on_box: Array, on_floor: Array, width: float) -> tuple[Array, Array]:
    """Return slope and curvature of the log likelihood with respect to each pixel's distance to the outline.

    Curvature is the complete-data curvature less the missing information (Louis 1982): a pixel that cannot tell box from floor
    does not locate the edge.
    """
    hit = np.exp(-0.5 * x * x - 0.9189385332 - log_ndtr(x)) / width
    missed = np.exp(-0.5 * x * x - 0.9189385332 - log_ndtr(-x)) / width
    slope = on_box * hit - on_floor * missed
    complete = on_box * hit * (hit + x / width) + on_floor * missed * (missed - x / width)
    missing = on_box * on_floor / np.maximum(on_box + on_floor, 1e-300) * (hit + missed) ** 2
    return slope, np.maximum(complete - missing, 0.0)

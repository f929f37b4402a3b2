"""What did each pixel see, the box or what lies beside it? The mixture at the heart of the likelihood.

A pixel's ray sees the box with probability Phi(s / w), where s is its signed distance to the box's outline in pixels and w the
blur, and the floor (or clutter) otherwise. Each has a density for the range that comes back and a chance that none does; on the
outline itself a pixel may also mix the two. Where floor and face have the same range the mixture cannot tell them apart, so the
contact line says nothing about the outline, by itself (ours). Beyond six blurs of the outline only one of the two is possible,
and only that one is worked out.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from viewgain.arrays import Array, Indices, Mask, Points, Points2
from viewgain.box import Box, EdgeDistances, Hits, Outline, box_hits, edge_distances, floor_hits, outline
from viewgain.camera import Sensor
from viewgain.measure._range_image import ImagePlane

STRAY = 0.02
"""Share of returns from the box that are nowhere near it (multipath, crosstalk)."""
CLUTTER = 0.10
"""Share of rays beside the box that meet something other than the floor."""
SHORT_BY = 0.06
"""By how much floor beside an object may read short, metres (Sensor.short_floor): evenly between nothing and this."""
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
FAR = 1e3
"""Stands for a surface that a ray never meets, metres."""
LEAST_DENSITY = 1e-12
"""No reading is held for less likely than this, per metre."""
BAND = 6.0
"""Beyond this many blurs from the outline a pixel saw one thing only (the chance of the other is 1e-9)."""
_TOLD_APART = 3.0
"""A range this many sigma from a surface is told from it."""
_MIXED_BAND = 3.0
"""The like of :data:`BAND` for mixed pixels, pixels."""


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
    plane: ImagePlane
    """The image that they are of."""

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
            self.plane,
        )


@dataclass(frozen=True, slots=True)
class Softness:
    """How sharply the fit looks: wide at first, so that it sees edges from afar, then as sharp as the camera."""

    edge: float
    """Blur of the outline, pixels."""
    extra_sigma: float = 0.0
    """Added to the range noise, metres."""
    settled: float = 0.02
    """A gain in log likelihood under this ends the climb at this softness."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """One of the two things a pixel may have seen: where its ray meets it, and how well the range agrees."""

    at: Indices
    """(m,) the pixels that may have seen it, ascending."""
    hits: Hits
    """Where their rays meet the surface."""
    sigma: Array
    """(m,) standard deviation of the range, metres."""
    z: Array
    """(m,) measured minus predicted range over sigma; NaN for a missing return."""
    gauss: Array
    """(m,) share of the density below that the surface itself explains (not strays)."""
    density: Array
    """(m,) density of what the pixel reported, a range or nothing, had it seen this surface."""

    def take(self, chosen: Indices) -> "Surface":
        """Return a subset of the pixels."""
        columns = (values[chosen] for values in (self.sigma, self.z, self.gauss, self.density))
        return Surface(self.at[chosen], self.hits.take(chosen), *columns)


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """The pixels near the outline, which may have seen either surface or both."""

    at: Indices
    """(k,) which pixels, ascending."""
    in_box: Indices
    """(k,) where they stand among the pixels of the box's surface."""
    in_floor: Indices
    """(k,) where they stand among the pixels of the floor's surface."""
    shown: Array
    """(k,) signed distance to where the camera shows the outline (:func:`bloom`), pixels."""
    on_both: Array
    """(k,) probability that the pixel mixed the two."""
    could_mix: Array
    """(k,) what that probability would be had it reported what an unmixed pixel does."""


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
    band: Band
    """The pixels near it."""
    on_box: Array
    """(m,) probability that each pixel of ``box.at`` saw the box."""
    on_floor: Array
    """(m,) probability that each pixel of ``floor.at`` saw what lies beside."""
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
    reach = max(BAND * softness.edge, _MIXED_BAND)
    near, far = np.flatnonzero(inside > -reach), np.flatnonzero(inside < reach)
    faces, ground = _faces(box, pixels, near, sensor, noise, softness), _ground(box, pixels, far, sensor, noise, softness)
    in_box, in_floor = np.flatnonzero(inside[near] < reach), np.flatnonzero(inside[far] > -reach)
    at = near[in_box]
    if pixels.other.any():
        faces, ground = _with_other_objects(pixels, faces, ground)

    inner = pixels.directions[at]
    inner[:, :2] += 0.5 * pixels.pitch * shape.inward[edges.edge[at]]
    shown = inside[at] + bloom(faces.take(in_box), box_hits(box, inner), ground.take(in_floor), sensor)
    s, box_density, floor_density = shown, faces.density[in_box], ground.density[in_floor]
    seen, unseen = ndtr(s / softness.edge), ndtr(-s / softness.edge)
    mixing = FLYING * np.exp(-0.5 * (s / FLYING_REACH) ** 4)
    pure = seen * box_density + unseen * floor_density
    mixed = _mixed_density(pixels.ranges[at], faces, in_box, ground.hits.ranges[in_floor])
    density = np.maximum((1 - mixing) * pure + mixing * mixed, LEAST_DENSITY)
    share = (1 - mixing) / density
    on_box, on_floor = np.ones(len(near)), np.ones(len(far))
    on_box[in_box], on_floor[in_floor] = share * seen * box_density, share * unseen * floor_density

    total = np.empty(len(inside))
    total[far], total[near] = np.maximum(ground.density, LEAST_DENSITY), np.maximum(faces.density, LEAST_DENSITY)
    total[at] = density
    band = Band(at, in_box, in_floor, shown, mixing * mixed / density, mixing * pure / density)
    return Mixture(faces, ground, shape, edges, inside, band, on_box, on_floor, float(np.sum(np.log(total))))


def bloom(near: Surface, inner: Hits, far: Surface, sensor: Sensor) -> Array:
    """Return by how many pixels the brighter side of an edge grows over the darker one, positive outwards; (k,).

    A time-of-flight pixel on an edge adds up the light of both sides, so with amplitudes a and b, cos(incidence) / range^2 where
    both reflect alike, the share t of the way from the near to the far range is reached where the near side fills
    b (1 - t) / (a t + b (1 - t)) of the pixel. Readings closer than the camera's filter (or its noise) to one side count as that
    side's; the edge shows half way between the two limits. Where the face at the outline is a sliver, the brighter one a pixel
    further inside outshines it.
    """
    if sensor.kind != "tof" or sensor.footprint_px == 0:
        return np.zeros(len(near.sigma))
    front, back = np.minimum(near.hits.ranges, FAR), np.minimum(far.hits.ranges, FAR)
    a, b = np.maximum(near.hits.cosine, inner.cosine) * back**2, far.hits.cosine * front**2
    told = np.maximum(sensor.flying_filter * front, _TOLD_APART * near.sigma)
    t = np.clip(told / np.maximum(np.abs(back - front), 1e-6), 0.0, 0.5)
    nearer, farther = (b * (1 - t) / np.maximum(a * t + b * (1 - t), 1e-12) for t in (t, 1 - t))
    return np.asarray(sensor.footprint_px * (0.5 - (nearer + farther) / 2))


def _faces(box: Box, pixels: Pixels, at: Indices, sensor: Sensor, noise: float, softness: Softness) -> Surface:
    """Return the box's faces as the pixels ``at`` may have seen them."""
    hits = box_hits(box, pixels.directions[at])
    return _surface(pixels, at, hits, sensor, noise, softness, LOST_NEAR[0] + LOST_NEAR[1] * sensor.loss(hits.cosine), STRAY)


def _ground(box: Box, pixels: Pixels, at: Indices, sensor: Sensor, noise: float, softness: Softness) -> Surface:
    """Return the floor as the pixels ``at`` may have seen it."""
    hits = floor_hits(box, pixels.directions[at])
    beyond = ndtr((np.minimum(hits.ranges, FAR) / pixels.horizon - 1) / HORIZON_BLUR)
    lost = LOST_FAR[0] + LOST_FAR[1] * sensor.loss(hits.cosine)
    ground = _surface(pixels, at, hits, sensor, noise, softness, lost + beyond * np.maximum(LOST_BEYOND - lost, 0.0), CLUTTER)
    if sensor.short_floor == 0:
        return ground
    missed = hits.ranges - pixels.ranges[at]
    short = np.where((missed > 0) & (missed < SHORT_BY), sensor.short_floor / SHORT_BY, 0.0)
    return replace(ground, density=ground.density + short, gauss=ground.gauss * ground.density / (ground.density + short))


def _surface(
    pixels: Pixels, at: Indices, hits: Hits, sensor: Sensor, noise: float, softness: Softness, lost: Array, stray: float
) -> Surface:
    """Return one surface's density: a Gaussian about its range, uniform strays, and the chance of no return."""
    predicted = np.minimum(hits.ranges, FAR)
    sigma = noise * sensor.range_sigma(np.minimum(predicted, 10.0), hits.cosine)
    if softness.extra_sigma:
        sigma = np.hypot(sigma, softness.extra_sigma)
    z = (pixels.ranges[at] - predicted) / sigma
    missing = np.isnan(z)
    peak = (1 - stray) / np.sqrt(2 * np.pi) * np.exp(-0.5 * np.where(missing, np.inf, z * z)) / sigma
    density = np.where(missing, lost, (1 - lost) * (peak + stray / SPAN))
    return Surface(at, hits, sigma, z, peak / (peak + stray / SPAN), density)


def _with_other_objects(pixels: Pixels, near: Surface, far: Surface) -> tuple[Surface, Surface]:
    """Return the surfaces knowing which pixels saw another object: beside the box it replaces the floor, before it hides both."""
    hidden = pixels.other[near.at] & (pixels.ranges[near.at] < near.hits.ranges)
    other = pixels.other[far.at]
    return _overruled(near, hidden), _overruled(far, other)


def _overruled(surface: Surface, by_other: Mask) -> Surface:
    """Return a surface that says nothing about the pixels that saw another object instead."""
    return replace(
        surface,
        density=np.where(by_other, 1 / SPAN, surface.density),
        gauss=np.where(by_other, 0.0, surface.gauss),
    )


def _mixed_density(ranges: Array, faces: Surface, in_box: Indices, floor: Array) -> Array:
    """Return the (k,) density of a mixed pixel: uniform between the surfaces, blurred by the noise; an even chance of nothing."""
    face, sigma = np.minimum(faces.hits.ranges[in_box], FAR), faces.sigma[in_box]
    floor = np.minimum(floor, FAR)
    low = np.minimum(face, floor)
    high = np.clip(np.maximum(face, floor), low, np.maximum(low, SPAN))
    between = ndtr((ranges - low) / sigma) * ndtr((high - ranges) / sigma)
    density = between / np.maximum(high - low, 2 * sigma) + 0.05 / SPAN
    return np.where(np.isnan(ranges), 0.5, density)

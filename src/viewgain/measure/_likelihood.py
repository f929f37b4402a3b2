"""The likelihood of a range image given a box on a floor, with its gradient and curvature.

Edges are located by which pixels hit and which miss, along their whole length, and faces by all their points, in one smooth
function (ours). Far from the outline it is weighted least squares.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr

from viewgain.arrays import Array, Indices
from viewgain.box import PARAMETERS, Box, Hits, edge_cosines, edge_jacobian, range_jacobian
from viewgain.camera import Sensor
from viewgain.measure._mixture import FLYING_REACH, Mixture, Pixels, Softness, Surface, mix

_EDGE_REACH = 8.0
"""Beyond this many blurs from the outline a pixel says nothing about it (its slope is under 1e-14)."""
_NEGLIGIBLE = 1e-3
_HALF_LOG_TWO_PI = 0.9189385332046727


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Value and derivatives of the log likelihood at one box, and what each pixel was taken for."""

    value: float
    """Log likelihood, up to a constant."""
    gradient: Array
    """(9,) its derivative with respect to a step of the box (Box.moved)."""
    information: Array
    """(9, 9) its negative curvature (positive semi-definite approximation)."""
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
    edge_cosine: Array
    """(k,) cosine of incidence on the face that each edge bounds."""


@dataclass(frozen=True, slots=True, eq=False)
class _Readings:
    """Range readings as linear equations: rows of the Jacobian with a weight and a residual each."""

    rows: Array
    """(m, 9)."""
    precision: Array
    """(m,) responsibility over sigma squared."""
    slope: Array
    """(m,) responsibility times residual over sigma squared."""
    ranges: Array
    """(m,) measured ranges, metres."""


def log_likelihood(box: Box, pixels: Pixels, sensor: Sensor, noise: float, softness: Softness) -> float:
    """Return the log likelihood alone; the arguments are those of :func:`evaluate`."""
    return mix(box, pixels, sensor, noise, softness).value


def evaluate(box: Box, pixels: Pixels, sensor: Sensor, noise: float, softness: Softness) -> Evaluation:
    """Return the log likelihood of ``pixels`` given ``box``, with its gradient and information.

    Args:
        box: The hypothesis, with its floor.
        pixels: What the camera saw.
        sensor: Gives the shape of the noise over range and incidence, and of grazing loss.
        noise: Factor on the sensor's noise, as estimated from this scan.
        softness: Blur of outline and range.
    """
    mixture = mix(box, pixels, sensor, noise, softness)
    faces = _readings(box, pixels, mixture.box, mixture.on_box, np.inf)
    floor = _readings(box, pixels, mixture.floor, mixture.on_floor, pixels.horizon)
    gradient, information, systematic = np.zeros(PARAMETERS), np.zeros((PARAMETERS, PARAMETERS)), np.zeros((PARAMETERS, 2))
    for readings in (faces, floor):
        weighted = readings.rows.T * readings.precision
        gradient += readings.rows.T @ readings.slope
        information += weighted @ readings.rows
        systematic += weighted @ np.stack([readings.ranges, np.ones(len(readings.ranges))], axis=1)

    near = np.flatnonzero(np.abs(mixture.inside) < _EDGE_REACH * softness.edge)
    slope, curvature = _edge_terms(mixture, near, softness.edge)
    rows = edge_jacobian(box, mixture.shape, mixture.edges.take(near)) / pixels.pitch
    gradient += rows.T @ slope
    information += (rows.T * curvature) @ rows
    corners = np.arange(len(mixture.shape.vertices))
    by_edge = np.where(mixture.edges.edge[near] == corners[:, None], curvature, 0.0)
    residual = np.where(mixture.on_box > mixture.on_floor, mixture.box.z, mixture.floor.z)
    return Evaluation(
        mixture.value,
        gradient,
        information,
        mixture.inside,
        residual,
        mixture.box.hits,
        systematic,
        by_edge @ rows,
        by_edge.sum(axis=1),
        edge_cosines(box, mixture.shape),
    )


def _readings(box: Box, pixels: Pixels, surface: Surface, probability: Array, horizon: float) -> _Readings:
    """Return the range readings on one surface.

    Readings near the ``horizon`` are left out: beyond it nothing comes back, so of those just before it only the short ones
    do, and they would tilt the floor.
    """
    responsibility = probability * surface.gauss
    used = np.flatnonzero((responsibility > _NEGLIGIBLE) & (surface.hits.ranges < horizon - 4 * surface.sigma))
    precision = responsibility[used] / surface.sigma[used] ** 2
    slope = precision * surface.z[used] * surface.sigma[used]
    return _Readings(range_jacobian(box, pixels.directions[used], surface.hits.take(used)), precision, slope, pixels.ranges[used])


def _edge_terms(mixture: Mixture, near: Indices, blur: float) -> tuple[Array, Array]:
    """Return slope and curvature of the log likelihood with respect to the distances of the pixels ``near`` the outline.

    Curvature is the complete-data curvature less the missing information (Louis 1982): a pixel that cannot tell box from floor
    does not locate the edge.
    """
    x, on_box, on_floor = mixture.inside[near] / blur, mixture.on_box[near], mixture.on_floor[near]
    log_phi = -0.5 * x * x - _HALF_LOG_TWO_PI
    hit, missed = np.exp(log_phi - log_ndtr(x)) / blur, np.exp(log_phi - log_ndtr(-x)) / blur
    slope = on_box * hit - on_floor * missed
    complete = on_box * hit * (hit + x / blur) + on_floor * missed * (missed - x / blur)
    missing = on_box * on_floor / np.maximum(on_box + on_floor, 1e-300) * (hit + missed) ** 2
    # A mixed pixel sits on the outline: its chance falls off as exp(-(s / reach)^4 / 2).
    mixed, inside = mixture.on_both[near], mixture.inside[near]
    slope += (mixture.could_mix[near] - mixed) * 2 * inside**3 / FLYING_REACH**4
    return slope, np.maximum(complete - missing, 0.0) + mixed * 6 * inside**2 / FLYING_REACH**4

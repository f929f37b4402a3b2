"""How likely is what a camera saw, given a box? Value, gradient and information of the mixture of :mod:`._mixture`.

Edges are located by which pixels hit and which miss, along their whole length, and faces by all their points, in one smooth
function (ours). Far from the outline it is weighted least squares.

The rows of the Jacobian are never written out: on one plane, and along one edge, they span three and two dimensions, so sums over
pixels are taken there and carried to the nine parameters once per plane and edge.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import log_ndtr

from viewgain.arrays import Array
from viewgain.box import (
    PARAMETERS,
    PLANE_NORMALS,
    Box,
    Hits,
    edge_cosines,
    edge_end_jacobians,
    range_jacobian_factors,
)
from viewgain.camera import Sensor
from viewgain.measure._bare_floor import BareFloor
from viewgain.measure._mixture import FLYING_REACH, Mixture, Pixels, Softness, mix
from viewgain.measure._readings import Readings, bare_readings, shown_readings

_HALF_LOG_TWO_PI = 0.9189385332046727


@dataclass(frozen=True, slots=True, eq=False)
class Derivatives:
    """How the log likelihood changes with the box, and with where its edges are shown."""

    gradient: Array
    """(9,) its derivative with respect to a step of the box (Box.moved)."""
    information: Array
    """(9, 9) its negative curvature (positive semi-definite approximation)."""
    edge_pull: Array
    """(k, 9) gradient caused by each edge of the outline being shown one pixel too far out."""
    edge_precision: Array
    """(k,) information about where each edge of the outline lies, per square pixel."""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The log likelihood at one box, and what each pixel was taken for; derivatives, if asked for, cost half as much."""

    box: Box
    """The box, in the frame of the camera that took the pixels."""
    pixels: Pixels
    """What the camera saw."""
    sensor: Sensor
    """Its noise model."""
    softness: Softness
    """How sharply it was looked at."""
    mixture: Mixture
    """What each pixel was taken for."""
    bare: Readings | None = None
    """Readings of the bare floor, where an empty scene says where it is."""

    @cached_property
    def value(self) -> float:
        """Log likelihood, up to a constant."""
        return self.mixture.value + (0.0 if self.bare is None else self.bare.log_density)

    @property
    def _all_readings(self) -> tuple[Readings, ...]:
        shown = shown_readings(self.pixels, self.sensor, self.mixture)
        return shown if self.bare is None else (*shown, self.bare)

    @cached_property
    def derivatives(self) -> Derivatives:
        """Its derivatives."""
        return _derivatives(self)

    @property
    def systematic(self) -> Array:
        """(9, 4) gradient caused by one unit of each systematic error of the ranges (Sensor.systematic_shapes)."""
        gradient = np.zeros((PARAMETERS, 4))
        for readings in self._all_readings:
            shapes = self.sensor.systematic_shapes(readings.ranges)
            for mine, local, basis in range_jacobian_factors(self.box, readings.directions, readings.hits):
                gradient += basis.T @ ((local * readings.precision[mine]) @ shapes[mine])
        return gradient

    @property
    def readings(self) -> Array:
        """(6,) how many range readings lie on each plane of the box."""
        own = self.mixture.box
        return np.asarray(
            np.bincount(own.hits.planes, self.mixture.on_box * own.gauss, minlength=len(PLANE_NORMALS)), dtype=float
        )

    @property
    def edge_cosine(self) -> Array:
        """(k,) cosine of incidence on the face that each edge bounds."""
        return edge_cosines(self.box, self.mixture.shape)

    @property
    def inside(self) -> Array:
        """(n,) signed distance to the outline, pixels, positive inside."""
        return self.mixture.inside

    @property
    def hits(self) -> Hits:
        """Where the (n,) rays meet the box; NaN, plane 0 and cosine 0 far outside the outline."""
        own, count = self.mixture.box, len(self.inside)
        hits = Hits(np.full(count, np.nan), np.zeros(count, dtype=np.intp), np.zeros(count))
        hits.ranges[own.at], hits.planes[own.at], hits.cosine[own.at] = own.hits.ranges, own.hits.planes, own.hits.cosine
        return hits

    @property
    def residual(self) -> Array:
        """(n,) measured minus predicted range over its sigma, for what the pixel more probably saw; NaN for missing returns."""
        mixture, band = self.mixture, self.mixture.band
        residual = np.full(len(self.inside), np.nan)
        residual[mixture.floor.at], residual[mixture.box.at] = mixture.floor.z, mixture.box.z
        seen = mixture.on_box[band.in_box] > mixture.on_floor[band.in_floor]
        residual[band.at] = np.where(seen, mixture.box.z[band.in_box], mixture.floor.z[band.in_floor])
        return residual


def evaluate(
    box: Box, pixels: Pixels, sensor: Sensor, noise: float, softness: Softness, bare: BareFloor | None = None
) -> Evaluation:
    """Return the log likelihood of ``pixels`` given ``box``.

    Args:
        box: The hypothesis, with its floor.
        pixels: What the camera saw.
        sensor: Gives the shape of the noise over range and incidence, and of grazing loss.
        noise: Factor on the sensor's noise, as estimated from this scan.
        softness: Blur of outline and range.
        bare: What the camera saw of the floor alone; None where its pixels are to say where that is.
    """
    readings = None if bare is None else bare_readings(box, bare, sensor, noise, softness)
    return Evaluation(box, pixels, sensor, softness, mix(box, pixels, sensor, noise, softness), readings)


def _derivatives(evaluation: Evaluation) -> Derivatives:
    box, pixels, mixture = evaluation.box, evaluation.pixels, evaluation.mixture
    gradient, information = np.zeros(PARAMETERS), np.zeros((PARAMETERS, PARAMETERS))
    for readings in evaluation._all_readings:
        for mine, local, basis in range_jacobian_factors(box, readings.directions, readings.hits):
            weighted = local * readings.precision[mine]
            gradient += basis.T @ (weighted @ readings.misfit[mine])
            information += basis.T @ (weighted @ local.T) @ basis

    slope, curvature = _edge_terms(mixture, evaluation.softness.edge)
    edge, along = mixture.edges.edge[mixture.band.at], mixture.edges.along[mixture.band.at]
    ends = np.stack(edge_end_jacobians(box, mixture.shape), axis=1) / pixels.pitch  # [edges, 2, 9]
    share = (1 - along, along)
    counted = len(ends)
    first, both, second = (np.bincount(edge, curvature * a * b, counted) for a, b in ((share[0],) * 2, share, (share[1],) * 2))
    gram = np.stack([first, both, both, second], axis=1).reshape(-1, 2, 2)  # [edges, 2, 2]
    push = np.stack([np.bincount(edge, slope * a, counted) for a in share], axis=1)  # [edges, 2]
    carried = gram @ ends  # [edges, 2, 9]
    return Derivatives(
        gradient + push.ravel() @ ends.reshape(-1, PARAMETERS),
        information + ends.reshape(-1, PARAMETERS).T @ carried.reshape(-1, PARAMETERS),
        carried.sum(axis=1),
        gram.sum(axis=(1, 2)),
    )


def _edge_terms(mixture: Mixture, blur: float) -> tuple[Array, Array]:
    """Return slope and curvature (k,) of the log likelihood with respect to the distances of the pixels near the outline.

    Curvature is the complete-data curvature less the missing information (Louis 1982): a pixel that cannot tell box from floor
    does not locate the edge.
    """
    band = mixture.band
    inside, on_box, on_floor = band.shown, mixture.on_box[band.in_box], mixture.on_floor[band.in_floor]
    x = inside / blur
    log_phi = -0.5 * x * x - _HALF_LOG_TWO_PI
    hit, missed = np.exp(log_phi - log_ndtr(x)) / blur, np.exp(log_phi - log_ndtr(-x)) / blur
    slope = on_box * hit - on_floor * missed
    complete = on_box * hit * (hit + x / blur) + on_floor * missed * (missed - x / blur)
    missing = on_box * on_floor / np.maximum(on_box + on_floor, 1e-300) * (hit + missed) ** 2
    # A mixed pixel sits on the outline: its chance falls off as exp(-(s / reach)^4 / 2).
    slope += (band.could_mix - band.on_both) * 2 * inside**3 / FLYING_REACH**4
    return slope, np.maximum(complete - missing, 0.0) + band.on_both * 6 * inside**2 / FLYING_REACH**4

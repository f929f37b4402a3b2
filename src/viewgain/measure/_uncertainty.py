"""From curvature to error bars: noise, what calibration leaves, how far real surfaces stray, and dimensions nobody saw."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Array, Indices
from viewgain.box import PARAMETERS
from viewgain.camera import Sensor
from viewgain.measure._fit import SHARP, Fit, View, marginal
from viewgain.measure._likelihood import Evaluation
from viewgain.measure._mixture import Pixels
from viewgain.measure._stretch import profile, returned, stays_level

PRIOR_EXTENT = (0.02, 2.0)
"""The stated prior on a dimension is log-uniform between these, metres."""
OPEN_SHARE = 0.15
"""A dimension whose standard deviation exceeds this share of it is open: the scan does not bound it like a measurement."""
OPEN_TEMPER = 0.2
"""Share of its log likelihood that an open dimension's profile is believed: it rests on missing returns, whose chances a sensor
model knows only roughly."""
FAR_SHARE = 0.1
"""Whether a cut box's extent is bounded is asked at least this share of it further out. Nearer than that the likelihood is a
staircase of pixels: a fit that rests on one of its steps has higher ones beside it, and they tell nothing about the far side."""
_TRIED = 12
"""Lengths at which the profile of an open dimension is fitted."""
SYSTEMATIC = 5
"""How many errors all pixels share: scale, offset and wave (two phases) of the ranges, and the shift of edges."""
COMMON_EDGES = 0.6
"""Share of the standard deviation of edge shifts that all edges of all views have in common: one camera mixes its pixels, and
loses its grazing returns, alike everywhere, so these errors do not average out. Chosen on development seeds (docs/fusing.md)."""
Z90 = 1.6448536269514722
"""Half-width of a 90 % normal interval, in standard deviations."""
LOOSE_PRIOR = np.diag([1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0])
"""(9, 9) information of the prior: 1 rad on each angle, 0.5 m on each length."""
_BLOCK_PX = 6.0
_MIN_BLOCK = 12


@dataclass(frozen=True, slots=True)
class Interval:
    """A 90 % interval; ``high`` is inf and ``sigma`` nan where nothing bounds the quantity from above."""

    low: float
    """Lower end (5 % quantile)."""
    high: float
    """Upper end (95 % quantile), or inf."""
    sigma: float
    """Standard deviation, or nan."""


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What scans say about a box, in the tangent space of its estimate: it adds up over views.

    Or what each of a stack of views says, (..., 9, 9) and (..., 9, 5); sum and covariance are then of each.
    """

    information: Array
    """(9, 9) information, as if noise were independent from pixel to pixel."""
    systematic: Array
    """(9, 5) gradient caused by one unit of each systematic error of the ranges, and by one sigma of shift of all edges."""
    inflation: float = 1.0
    """Variance over what independent noise would give (:func:`correlation_factor`)."""

    def plus(self, other: "Knowledge") -> "Knowledge":
        """Return what both say together; one camera, so both share its systematic error."""
        return Knowledge(
            self.information + other.information, self.systematic + other.systematic, max(self.inflation, other.inflation)
        )

    def take(self, chosen: Indices | int) -> "Knowledge":
        """Return what some of a stack say, or one of them."""
        return Knowledge(self.information[chosen], self.systematic[chosen], self.inflation)

    def covariance(self, sensor: Sensor) -> Array:
        """Return the (9, 9) covariance of the box: noise, inflated, plus systematic error.

        With information L, inflation k, the camera's learned spread c and systematic gradient S the covariance is
        k c^2 L^-1 + L^-1 S diag(sd^2) S^T L^-1 (ours); the shift that all edges share has standard deviation one.
        A loose prior (1 rad, 0.5 m) keeps directions finite that no view fixes.
        """
        spread = np.linalg.inv(self.information + LOOSE_PRIOR)
        response = spread @ self.systematic * (*sensor.systematic_sd, COMMON_EDGES)
        return np.asarray(self.inflation * sensor.spread**2 * spread + response @ response.mT)


def knowledge(fit: Fit) -> Knowledge:
    """Return what the views of a fit say about its box, with edge and pose errors integrated out."""
    information, systematic = np.zeros((PARAMETERS, PARAMETERS)), np.zeros((PARAMETERS, SYSTEMATIC))
    for view, evaluation in zip(fit.views, fit.evaluations, strict=True):
        added, shared = marginal(*believed(view, evaluation), view.pose_precision)
        information += added
        systematic += shared
    return Knowledge(information, systematic, correlation(fit))


def believed(view: View, evaluation: Evaluation) -> tuple[Array, Array]:
    """Return one view's (9, 9) information, and its (9, 5) gradients for what all its pixels, or all its edges, share.

    Each edge's own shift is integrated out of the information; of a shift d that leaves d / (1 + precision sigma^2).
    """
    sigma = view.sensor.edge_sigma(evaluation.edge_cosine)
    found = evaluation.derivatives
    free = without_edge_bias(found.information, found.edge_pull, found.edge_precision, sigma)
    return free, np.column_stack([evaluation.systematic, common_shift(found.edge_pull, found.edge_precision, sigma)])


def common_shift(edge_pull: Array, edge_precision: Array, edge_sigma: Array) -> Array:
    """Return the (9,) gradient that is left of one sigma of shift of all edges once each edge's own shift is integrated out.

    The arguments are those of :func:`without_edge_bias`.
    """
    share = edge_sigma / (1 + edge_precision * edge_sigma**2)
    return np.asarray((share[..., None, :] @ edge_pull)[..., 0, :])


def correlation(fit: Fit) -> float:
    """Return the mean over the views of a fit of :func:`correlation_factor`."""
    factors = [correlation_factor(e, v.pixels) for e, v in zip(fit.evaluations, fit.views, strict=True)]
    return float(np.mean(np.array(factors)))


def without_edge_bias(information: Array, edge_pull: Array, edge_precision: Array, edge_sigma: Array) -> Array:
    """Return (9, 9) information after each outline edge's own offset, N(0, edge_sigma), is integrated out (Schur complement).

    Mixed pixels, and the filters of cameras against them, shift an edge as a whole; without this a long edge would claim to
    be known to a hundredth of a pixel. Takes stacks.

    Args:
        information: (9, 9) information if every edge were shown where it is.
        edge_pull: (k, 9) gradient per pixel of shift of each edge.
        edge_precision: (k,) information about each edge's place, per square pixel.
        edge_sigma: (k,) standard deviation of each edge's shift, pixels.
    """
    share = 1 / (edge_precision + 1 / np.maximum(edge_sigma, 1e-6) ** 2)
    return np.asarray(information - (edge_pull.mT * share[..., None, :]) @ edge_pull)


def correlation_factor(evaluation: Evaluation, pixels: Pixels) -> float:
    """Return by how much the means of residuals over 6 x 6 pixel blocks vary more than independent noise would let them, >= 1.

    Bent faces, rough floors, multipath and filters in the camera all make neighbouring errors alike; a block mean shows it.
    """
    residual, inside = evaluation.residual, evaluation.inside
    with np.errstate(invalid="ignore"):
        used = np.flatnonzero((np.abs(inside) > 2) & (np.abs(residual) < 4))
    if len(used) < _MIN_BLOCK:
        return 1.0
    cell = np.floor(pixels.image[used] / (pixels.pitch * _BLOCK_PX)).astype(int)
    cell -= cell.min(axis=0)
    surface = np.where(inside[used] > 0, evaluation.hits.planes[used], PARAMETERS)
    key = (cell[:, 1] * (cell[:, 0].max() + 1) + cell[:, 0]) * (PARAMETERS + 1) + surface
    _, block, count = np.unique(key, return_inverse=True, return_counts=True)
    mean = np.bincount(block, residual[used]) / count
    full = count >= _MIN_BLOCK
    if full.sum() < 5:
        return 1.0
    return max(1.0, float(np.mean(mean[full] ** 2 * count[full])))


@dataclass(frozen=True, slots=True)
class Shown:
    """What the image shows of one extent of a box."""

    cut: bool
    """Whether the box leaves the image. The curvature of the likelihood then tells only that an edge is no nearer than the
    border, so it bounds the extent from above only if the likelihood falls on the far side too."""
    spanned: bool
    """Whether the camera sees both of its ends. If the box is cut and they are not seen, the far end may be anywhere."""
    reach: float
    """How far the returns on the box stretch along it, metres."""


def extent_interval(axis: int, fit: Fit, known: Knowledge, spread: Array, shown: Shown) -> Interval:
    """Return the 90 % interval of one extent: Gaussian where the scan bounds it, else from likelihood profile and prior.

    Args:
        axis: Which extent, 0 to 2.
        fit: The fitted box.
        known: What its views say.
        spread: Its (9, 9) covariance.
        shown: What the image shows of the extent.
    """
    value = float(fit.box.extents[axis])
    if shown.cut and not shown.spanned:
        return Interval(min(max(PRIOR_EXTENT[0], shown.reach), value), np.inf, np.nan)
    sigma = float(np.sqrt(spread[6 + axis, 6 + axis]))
    if sigma >= OPEN_SHARE * value or not shown.spanned:
        return _profiled(axis, fit)
    if shown.cut and _is_flat_beyond(axis, fit, known):
        return Interval(value - Z90 * sigma, np.inf, np.nan)
    return Interval(value - Z90 * sigma, value + Z90 * sigma, sigma)


def _is_flat_beyond(axis: int, fit: Fit, known: Knowledge) -> bool:
    """Return whether the likelihood stays level, four sigma or a tenth further out."""
    value = float(fit.box.extents[axis])
    sigma = float(np.sqrt(np.linalg.inv(known.information + LOOSE_PRIOR)[6 + axis, 6 + axis]))
    return stays_level(fit, axis, value + max(4 * sigma, FAR_SHARE * value), SHARP[0])


def _profiled(axis: int, fit: Fit) -> Interval:
    """Return the interval of an extent that the scan leaves open, from profile likelihood times the log-uniform prior.

    The upper end is open where the likelihood never falls by more than two units up to the prior's end.
    """
    value = float(fit.box.extents[axis])
    evidence = replace(fit, views=tuple(returned(view) for view in fit.views))
    nodes = np.sort([*np.geomspace(*PRIOR_EXTENT, _TRIED), value])
    fits = profile(evidence, axis, nodes, SHARP[0])
    heights = np.array([tried.value for tried in fits]) + np.log(nodes)  # a fit's value holds the prior, and so does the grid
    return interval_of_profile(value, nodes, heights)


def interval_of_profile(value: float, nodes: Array, heights: Array) -> Interval:
    """Return the 90 % interval of an extent from its log likelihood, tempered, under the log-uniform prior.

    Args:
        value: The likeliest extent, metres.
        nodes: (k,) ascending extents that were tried, ``value`` among them, metres.
        heights: (k,) log likelihood of each.
    """
    grid = np.geomspace(*PRIOR_EXTENT, 90)
    log_likelihood = OPEN_TEMPER * np.interp(np.log(grid), np.log(nodes), heights - heights.max())
    posterior = np.exp(log_likelihood - log_likelihood.max())  # a peak between two places of the grid may be far above both
    posterior /= posterior.sum()
    low, high = np.interp([0.05, 0.95], np.cumsum(posterior), grid)
    if log_likelihood[-1] > -2.0:
        return Interval(float(min(low, value)), np.inf, np.nan)
    mean, step = float(posterior @ grid), value * (grid[1] / grid[0] - 1)
    sigma = float(np.sqrt(posterior @ (grid - mean) ** 2 + step**2 / 12))
    margin = Z90 * step / 2
    return Interval(float(min(low, value - margin)), float(max(high, value + margin)), sigma)

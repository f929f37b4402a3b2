"""What a confidence is worth: the cost of the decisions that are kept when the least sure are left out, and its honesty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from viewgain.arrays import Array, Indices, Vector
from viewgain.evaluation._quantity import Quantity
from viewgain.evaluation._risk import KEPT, risk_coverage, risks_at
from viewgain.evaluation._wilson import wilson

STEPS = tuple(k / 20 for k in range(1, 21))
"""Shares of decisions kept at which curves are given."""
DRAWS = 500
"""How often the decisions are drawn anew: each draw orders them twice, so fewer than for plain means."""
BINS = 5
"""Groups of equally many decisions, by their confidence."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The decisions that are kept."""

    share: float
    """Of all decisions, the surest."""
    least: float
    """Confidence of the least sure of them."""
    error: float
    """Their mean error."""
    oracle: float
    """Mean error of the oracle's choice on the same boxes."""
    nearly: float
    """Share of them within two points of the best."""


@dataclass(frozen=True, slots=True)
class Bin:
    """A group of decisions of like confidence."""

    count: int
    """How many."""
    said: float
    """Their mean confidence."""
    found: float
    """Share of them within two points of the best."""
    low: float
    """Lower end of its 95 % Wilson interval."""
    high: float
    """Upper end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Selective:
    """What leaving out decisions brings. Risks are shares of the kept decisions that are not within two points of the best."""

    kept: tuple[Kept, ...]
    """At the shares of :data:`viewgain.evaluation.KEPT`."""
    bins: tuple[Bin, ...]
    """Predicted and observed, from unsure to sure."""
    calibration_error: Quantity
    """Mean of \\|said - found\\| over the bins, by their size."""
    by_chance: float
    """What that would be on average if every confidence were right: it is never 0 with few decisions."""
    area: Quantity
    """Mean risk over all shares kept, the area under the curve, by the confidence."""
    area_by_margin: Quantity
    """The same by the margin between the best and the next best score."""
    area_at_random: float
    """The same in random order: the risk of all."""
    area_by_truth: float
    """The same by the truth: nobody can do better."""
    gain: Quantity
    """Area at random minus area by the confidence, the same decisions drawn for both; positive where it tells bad ones apart."""
    steps: tuple[float, ...]
    """(n,) shares kept of the curves."""
    curve: tuple[float, ...]
    """(n,) risk by the confidence."""
    curve_by_margin: tuple[float, ...]
    """(n,) by the margin."""
    curve_by_truth: tuple[float, ...]
    """(n,) by the truth."""


def selective(
    confidence: ArrayLike, margin: ArrayLike, nearly: ArrayLike, error: ArrayLike, oracle: ArrayLike, *, rng: np.random.Generator
) -> Selective:
    """Return what leaving out the least sure of B decisions brings.

    Args:
        confidence: (B,) chances, 0 to 1.
        margin: (B,) another confidence to hold beside it, the higher the surer.
        nearly: (B,) whether each decision is within two points of the best, 0 or 1.
        error: (B,) its expected error.
        oracle: (B,) that of the oracle's choice.
        rng: Draws the decisions for the intervals.

    Raises:
        DataError: If there is no decision, or not one of each.
    """
    sure, ahead, good = (np.asarray(each, dtype=float) for each in (confidence, margin, nearly))
    curves = {name: risks_at(order, 1 - good, STEPS) for name, order in (("sure", sure), ("ahead", ahead), ("truth", good))}
    draws = rng.integers(len(sure), size=(DRAWS, len(sure)))
    areas = np.array([(_area(sure[own], good[own]), _area(ahead[own], good[own]), 1 - good[own].mean()) for own in draws])
    errors = np.array([calibration_error(sure[own], good[own]) for own in draws])
    honest = [calibration_error(sure, rng.random(len(sure)) < sure) for _ in range(DRAWS)]
    area = _area(sure, good)
    return Selective(
        kept=_kept(sure, good, np.asarray(error, dtype=float), np.asarray(oracle, dtype=float)),
        bins=bins_of(sure, good),
        calibration_error=_quantity(calibration_error(sure, good), errors),
        by_chance=float(np.mean(honest)),
        area=_quantity(area, areas[:, 0]),
        area_by_margin=_quantity(_area(ahead, good), areas[:, 1]),
        area_at_random=float(1 - good.mean()),
        area_by_truth=_area(good, good),
        gain=_quantity(float(1 - good.mean()) - area, areas[:, 2] - areas[:, 0]),
        steps=STEPS,
        curve=curves["sure"],
        curve_by_margin=curves["ahead"],
        curve_by_truth=curves["truth"],
    )


def bins_of(confidence: ArrayLike, nearly: ArrayLike, bins: int = BINS) -> tuple[Bin, ...]:
    """Return groups of about equally many decisions, from the least sure to the surest; fewer where there are fewer decisions."""
    sure, good = np.asarray(confidence, dtype=float), np.asarray(nearly, dtype=float)
    groups = [own for own in np.split(np.argsort(sure, kind="stable"), _ends(len(sure), bins)[:-1]) if len(own)]
    return tuple(
        Bin(len(own), float(sure[own].mean()), float(good[own].mean()), *wilson(int(good[own].sum()), len(own))) for own in groups
    )


def calibration_error(confidence: ArrayLike, nearly: ArrayLike, bins: int = BINS) -> float:
    """Return the mean distance of what was said from what was found in the groups of :func:`bins_of`, weighted by their size."""
    sure, good = np.asarray(confidence, dtype=float), np.asarray(nearly, dtype=float)
    apart = np.cumsum((sure - good)[np.argsort(sure, kind="stable")])[_ends(len(sure), bins) - 1]  # of a group, times its size
    return float(np.abs(np.diff(apart, prepend=0.0)).sum() / len(sure))


def _ends(count: int, bins: int) -> Indices:
    """Return where each of some groups ends that share out so many decisions; no group is empty."""
    groups = min(bins, count)
    return np.arange(1, groups + 1) * count // groups


def _area(order: Vector, good: Vector) -> float:
    return float(risk_coverage(order, 1 - good)[1].mean())


def _kept(sure: Vector, good: Vector, error: Vector, oracle: Vector) -> tuple[Kept, ...]:
    ordered = np.sort(sure)[::-1]
    columns = [risks_at(sure, values) for values in (error, oracle, good)]
    least = [float(ordered[max(int(np.ceil(share * len(sure) - 1e-9)), 1) - 1]) for share in KEPT]
    return tuple(Kept(*row) for row in zip(KEPT, least, *columns, strict=True))


def _quantity(value: float, drawn: Array) -> Quantity:
    low, high = np.quantile(drawn, [0.025, 0.975])
    return Quantity(value, float(low), float(high))

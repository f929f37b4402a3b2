"""What a histogram of volume errors says a view is worth. A scan without an estimate is a miss everywhere: it is never good."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.gain._bits import Counts
from viewgain.gain._histogram import ErrorHistogram, bin_counts
from viewgain.gain._objective import Choice, Objective


@dataclass(frozen=True, slots=True)
class NearZero:
    """Share of all scans, misses included, whose error lies in the bin centred on zero: the source paper's histogram score."""

    widen: bool = False
    """Where no view has a scan in that bin, take in one more bin on each side, and so on until some view has one. Ours: the paper
    does not say what is chosen then, and an estimator with a bias leaves the bin empty."""

    @property
    def name(self) -> str:
        """Says whether it widens."""
        return "near_zero_widened" if self.widen else "near_zero"

    def gains(self, known: ErrorHistogram) -> Vector:
        """Return the (V,) shares, 0 to 1; all 0 where every scan is a miss."""
        middle, counts = known.rule.middle, known.counts
        near = counts[:, middle].copy()
        for step in range(1, middle + 1 if self.widen else 0):
            if near.any():
                break
            near += counts[:, middle - step] + counts[:, middle + step]
        return np.asarray(near / known.scans)


@dataclass(frozen=True, slots=True)
class ProbabilityWithin:
    """Share of all scans, misses included, whose error is at most the tolerance either way."""

    tolerance: float | None = None
    """Relative volume error; None takes the histogram's own."""

    def __post_init__(self) -> None:
        if self.tolerance is not None and not self.tolerance > 0:
            raise ConfigError(f"probability within: got a tolerance of {self.tolerance}, wanted a positive number")

    @property
    def name(self) -> str:
        """Says the tolerance if it is not the histogram's."""
        return "probability_within" if self.tolerance is None else f"probability_within_{self.tolerance:g}"

    def gains(self, known: ErrorHistogram) -> Vector:
        """Return the (V,) shares, 0 to 1; of the errors themselves, so bins do not blur them."""
        tolerance = known.rule.tolerance if self.tolerance is None else self.tolerance
        return np.asarray(np.mean(np.abs(known.errors) <= tolerance, axis=1))  # NaN compares as false


@dataclass(frozen=True, slots=True)
class ExpectedError:
    """Minus the mean of |error|, cut off at the rule's limit; a miss counts as the limit."""

    name: str = "expected_error"

    def gains(self, known: ErrorHistogram) -> Vector:
        """Return the (V,) negated means, from -limit to 0."""
        limit = known.rule.limit
        return np.asarray(-np.mean(np.minimum(np.nan_to_num(np.abs(known.errors), nan=limit), limit), axis=1))


@dataclass(frozen=True, slots=True)
class EntropyReduction:
    """How many bits narrower the distribution of outcomes is after the view than before. A miss is one more outcome.

    Before is the histogram's ``before``, or where nothing is known every outcome alike. Entropies are of the counted shares,
    which is too low by about (outcomes - 1) / (2 n ln 2) bits for n scans. A view that always errs alike is as good by this
    objective as one without error.
    """

    name: str = "entropy_reduction"

    def gains(self, known: ErrorHistogram) -> Vector:
        """Return the (V,) reductions, bits; negative for a view that leaves less known than before."""
        after = np.array([entropy(np.append(*row)) for row in zip(known.counts, known.missed, strict=True)])
        outcomes = known.counts.shape[1] + 1
        if known.before is None:
            return np.asarray(np.log2(outcomes) - after)
        missed = int(np.isnan(known.before).sum())
        return np.asarray(entropy(np.append(bin_counts(known.before, known.edges), missed)) - after)


def entropy(counts: Counts) -> float:
    """Return the entropy of counted outcomes, bits; 0 where nothing was counted."""
    share = counts[counts > 0] / max(counts.sum(), 1)
    return float(-(share * np.log2(share)).sum()) + 0.0  # no negative zero


ONE_HOT: Choice[ErrorHistogram] = Choice(NearZero(widen=True), 1.0, 0.0)
"""The source paper's target: 1 for the view with the most scans near zero, 0 for the others."""
SOFT: Choice[ErrorHistogram] = Choice(NearZero(widen=True), 0.8, 0.2)
"""The same as the authors' scripts have it: 0.8 and 0.2."""
HISTOGRAM_OBJECTIVES: dict[str, Objective[ErrorHistogram]] = {
    "one_hot": ONE_HOT,
    "soft": SOFT,
    "near_zero": NearZero(),
    "probability_within": ProbabilityWithin(),
    "expected_error": ExpectedError(),
    "entropy_reduction": EntropyReduction(),
}
"""By name, with the settings of the histogram's rule."""

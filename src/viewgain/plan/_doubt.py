"""How likely each candidate is the best one, when all that is known of the scores is a mean and a standard deviation each."""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from viewgain.arrays import Vector
from viewgain.plan._policy import Assessment

NODES = 2000
"""Points of the rule that integrates; the integrand rises from 0 to 1 at most, so its error is at most 1 / (2 nodes)."""
SURE = 1e-12
"""Least standard deviation: a score without any doubt."""


@runtime_checkable
class Hesitant(Protocol):
    """A policy that may decline to choose."""

    def abstention(self, assessments: tuple[Assessment, ...], reachable: NDArray[np.bool_], best: int) -> str | None:
        """Return in words why the policy stands by no choice, or None.

        Args:
            assessments: (V,) its own, of all candidates.
            reachable: (V,) which of them can be reached.
            best: The one with the highest score of those.
        """


def chances_of_best(scores: Vector, sigmas: Vector) -> Vector:
    """Return (V,) the probability that each candidate is the best, under independent normal scores; their sum is 1.

    P(k is best) is the integral over u from 0 to 1 of the product over j != k of Phi((x(u) - s_j) / sigma_j), where
    x(u) = s_k + sigma_k Phi^-1(u); by the midpoint rule. Candidates that are sure and equal share.

    Args:
        scores: (V,) means.
        sigmas: (V,) standard deviations, 0 or more, in the same unit.
    """
    spread = np.maximum(sigmas, SURE)
    steps = ndtri((np.arange(NODES) + 0.5) / NODES)
    chances = np.empty(len(scores))
    for k in range(len(scores)):
        reached = scores[k] + spread[k] * steps  # (n,)
        others = np.delete(np.arange(len(scores)), k)
        chances[k] = ndtr((reached[:, None] - scores[others]) / spread[others]).prod(axis=1).mean()
    return np.asarray(chances / chances.sum())

"""A policy's scores in the meaning of the truth where they can be brought to it: expected errors, the less the better."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from viewgain.arrays import Mask, Vector
from viewgain.plan import (
    CombinedPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    OnBelief,
    RehearsedPolicy,
    Seen,
    ViewPolicy,
    VolumeNetworkPolicy,
    weighted,
)

Meaning: TypeAlias = Literal["error", "sigma_left", "minus_score"]
"""What a policy's numbers are: expected |relative volume error|; the share of today's standard deviation of the volume that is
left after fusing; or nothing but an order, the score with its sign turned."""


@dataclass(frozen=True, slots=True, eq=False)
class Valued:
    """What a policy thinks of every position."""

    values: Vector
    """(V,) the less the better; NaN where it has no opinion."""
    meaning: Meaning
    """What they are."""


def valued(policy: ViewPolicy, seen: Seen) -> Valued:
    """Return what a policy thinks of the candidates of ``seen``, in their order."""
    if isinstance(policy, CombinedPolicy):
        seen = policy.model.measuring(seen)
        trust, one = policy.trust(policy.model.belief(seen)), valued(policy.model, seen)
        if trust == 1.0:
            return one
        two = valued(policy.network, seen)
        if one.meaning == two.meaning:  # policies of one unit up to a constant, which is gone here
            return Valued(weighted(one.values, two.values, trust), one.meaning)
    scores = policy.scores(seen)
    asked = policy.policy if isinstance(policy, OnBelief) else policy
    if isinstance(asked, ExpectedErrorPolicy | RehearsedPolicy):
        return Valued(1 - scores, "error")
    if isinstance(asked, CovariancePolicy):
        return Valued(1 - scores, "sigma_left")
    return Valued(-scores, "error" if isinstance(asked, VolumeNetworkPolicy) else "minus_score")


def rank_correlation(one: Vector, other: Vector, allowed: Mask) -> float | None:
    """Return Spearman's rank correlation of (V,) numbers over the positions allowed where both are known.

    None where there are fewer than three of them, or one or the other says the same of all.
    """
    from scipy.stats import spearmanr

    known = allowed & np.isfinite(one) & np.isfinite(other)
    if known.sum() < 3 or np.ptp(one[known]) == 0 or np.ptp(other[known]) == 0:
        return None
    return float(spearmanr(one[known], other[known]).statistic)

"""A calibrated confidence of a decision for the volume: the chance that no other view in reach is better by two points (ours).

A logistic regression on a few numbers that are known when the choice is made (:func:`decision_numbers`), fitted to decisions on
simulated boxes of which the truth is known from many scans (``python -m benchmarks confidence``). Whoever chose, the numbers come
from what model and network say of the choice, so decisions of different policies can be compared.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import expit, logit

from viewgain.arrays import Vector
from viewgain.plan._error_model import WITHIN
from viewgain.plan._nearly_best import LEAST, chance_of_nearly_best
from viewgain.plan._opinions import Opinions
from viewgain.plan._packaged import packaged

FILE = Path(__file__).parent / "confidence.json"
"""The one that comes with the package."""
NUMBERS = ("chance by the model", "chance by the network")
"""What is known of a decision, as log-odds (:func:`viewgain.plan.chance_of_nearly_best`). Few, for boxes of which the truth is
known are few; errors, gaps, near ties and the number of candidates are in both, and where the opinions part so do they."""


def decision_numbers(opinions: Opinions, chosen: int) -> Vector | None:
    """Return (F,) what is known of a decision, in the order of :data:`NUMBERS`; None where nobody has an opinion.

    Where one of the two has no opinion, or the model no weight, the other speaks for it.

    Args:
        opinions: Of all candidates.
        chosen: The candidate that was chosen, by whomever.

    Raises:
        ConfigError: If it cannot be reached.
    """
    both, allowed = opinions.both, opinions.reachable
    if np.any(np.isnan(both[allowed])):
        return None
    model = opinions.model if opinions.trust > 0 else both
    voices = [np.where(np.isnan(each), both, each) for each in (model, opinions.network)]
    chances = np.array([chance_of_nearly_best(each, allowed, chosen) for each in voices])
    return np.asarray(logit(np.clip(chances, LEAST, 1 - LEAST)), dtype=float)


@dataclass(frozen=True, slots=True, eq=False)
class Confidence:
    """Scales the numbers, weighs them, and makes the sum a chance."""

    mean: Vector
    """(F,) of the numbers that it was fitted to."""
    scale: Vector
    """(F,) their standard deviations."""
    weights: Vector
    """(F,) of the scaled numbers."""
    bias: float
    """Log-odds where all numbers are as their means."""
    fitted_to: tuple[str, ...]
    """What it was fitted to, in words."""

    def chance(self, numbers: Vector | None) -> float:
        """Return the chance of a decision of which (F,) numbers are known, 0 to 1; 0 of one that rests on nothing.

        Numbers count within three standard deviations of those that it was fitted to.
        """
        if numbers is None:
            return 0.0
        scaled = np.clip((numbers - self.mean) / self.scale, -WITHIN, WITHIN)
        return float(expit(scaled @ self.weights + self.bias))

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it; :func:`confidence_from` reads it."""
        return {
            "numbers": list(NUMBERS),
            "mean": self.mean.tolist(),
            "scale": self.scale.tolist(),
            "weights": self.weights.tolist(),
            "bias": self.bias,
            "fitted_to": list(self.fitted_to),
        }


def confidence_from(content: dict[str, Any]) -> Confidence:
    """Return the one of :meth:`Confidence.to_dict`; raises ValueError if it is about other numbers."""
    if tuple(content["numbers"]) != NUMBERS:
        raise ValueError(f"is about {content['numbers']}, wanted {list(NUMBERS)}")
    mean, scale, weights = (np.array(content[name], dtype=float) for name in ("mean", "scale", "weights"))
    if not mean.shape == scale.shape == weights.shape == (len(NUMBERS),):
        raise ValueError(f"has shapes {mean.shape}, {scale.shape} and {weights.shape}, wanted {len(NUMBERS)} numbers each")
    return Confidence(mean, scale, weights, float(content["bias"]), tuple(map(str, content["fitted_to"])))


@cache
def shipped_confidence() -> Confidence:
    """Return the one that comes with the package.

    Raises:
        ModelError: If its file is missing or broken.
    """
    return packaged(FILE, confidence_from)

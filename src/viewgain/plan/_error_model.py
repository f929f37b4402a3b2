"""The learned part of the expected error: how far real measurements are from what the covariance promises (ours).

A small perceptron, fitted to many runs of the real estimator (``python -m benchmarks error-model``). It shifts the log-odds of
the physical guess, by no more than ``MOST_SHIFT``: far from all it was fitted to, physics still has its say.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Array, Vector
from viewgain.plan._packaged import packaged

FILE = Path(__file__).parent / "error_model.json"
"""The one that comes with the package."""
MOST_SHIFT = 4.0
"""Largest shift of the log-odds."""
LEAST_CHANCE = 1e-4
"""Physical guesses are told within this and 1 minus this."""
WITHIN = 3.0
"""Circumstances count within so many standard deviations of those it was fitted to."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorModel:
    """Scales the circumstances, then layers of tanh, the last one linear with one output."""

    mean: Vector
    """(F,) of the circumstances it was fitted to, the log-odds of the physical guess last."""
    scale: Vector
    """(F,) their standard deviations."""
    layers: tuple[tuple[Array, Vector], ...]
    """Weights (outputs, inputs) and biases (outputs,)."""

    def corrected(self, physical: float, numbers: Vector) -> float:
        """Return the expected error, 0 to 1, of a physical guess under (F - 1,) circumstances."""
        odds = log_odds(physical)
        values = np.clip((np.append(numbers, odds) - self.mean) / self.scale, -WITHIN, WITHIN)
        *hidden, (weights, bias) = self.layers
        for inner, shift in hidden:
            values = np.tanh(inner @ values + shift)
        moved = odds + MOST_SHIFT * float(np.tanh((weights @ values + bias)[0] / MOST_SHIFT))
        return float(1 / (1 + np.exp(-moved)))

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it; :func:`error_model_from` reads it."""
        layers = [{"weights": weights.tolist(), "bias": bias.tolist()} for weights, bias in self.layers]
        return {"mean": self.mean.tolist(), "scale": self.scale.tolist(), "layers": layers}


def log_odds(chance: float) -> float:
    """Return log(p / (1 - p)) of a chance, kept off 0 and 1."""
    within = min(max(chance, LEAST_CHANCE), 1 - LEAST_CHANCE)
    return float(np.log(within / (1 - within)))


def error_model_from(content: dict[str, Any]) -> ErrorModel:
    """Return the model of :meth:`ErrorModel.to_dict`."""
    layers = tuple((np.array(each["weights"]), np.array(each["bias"])) for each in content["layers"])
    return ErrorModel(np.array(content["mean"]), np.array(content["scale"]), layers)


@cache
def shipped_error_model() -> ErrorModel:
    """Return the one that comes with the package.

    Raises:
        ModelError: If its file is missing or broken.
    """
    return packaged(FILE, error_model_from)

"""The learned part of the expected error: how far real measurements are from what the covariance promises (ours).

A few small perceptrons, fitted to many runs of the real estimator (``python -m benchmarks error-model``). Together they shift the
log-odds of there being no volume, and the logarithm of how far off one is, neither by more than ``MOST_SHIFT``: far from all that
they were fitted to, physics still has its say. The two are apart because a rare miss costs a hundred times what a usual error
does: a sum of both, fitted as one number, is all about misses, and says nothing true below a percent.
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
"""Largest shift of the log-odds and of the logarithm."""
LEAST_CHANCE = 1e-4
"""Chances count as within this and 1 minus this, errors as this at least."""
WITHIN = 3.0
"""Circumstances count within so many standard deviations of those it was fitted to."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What may come of measuring a box: no volume, or one that is off. Arrays of the same shape for many boxes or views."""

    missed: Array | float
    """Chance that there is no volume, 0 to 1."""
    off: Array | float
    """Expected |relative error| of the volume where there is one, 0 to 1."""

    @property
    def expected(self) -> Array | float:
        """Expected |relative volume error|, 0 to 1, where no volume counts as 1."""
        return self.missed + (1 - self.missed) * self.off


@dataclass(frozen=True, slots=True, eq=False)
class ErrorModel:
    """The mean of M perceptrons on scaled circumstances: layers of tanh, the last one linear with two outputs."""

    mean: Vector
    """(F,) of what it was fitted to: circumstances, then the two :func:`transformed` numbers of the physical guess."""
    scale: Vector
    """(F,) their standard deviations."""
    layers: tuple[tuple[Array, Array], ...]
    """Weights (M, outputs, inputs) and biases (M, outputs)."""

    def corrected(self, physical: Outcome, circumstances: Array) -> Outcome:
        """Return what to expect, by a physical guess and (F - 2,) circumstances; by many of each, (..., F - 2), of many."""
        guess = transformed(physical)
        numbers = np.concatenate([circumstances, guess], axis=-1)
        scaled = np.clip((numbers - self.mean) / self.scale, -WITHIN, WITHIN)
        values = scaled.reshape(-1, len(self.mean))  # [guesses, inputs]; of each member once it has passed a layer
        *hidden, (weights, bias) = self.layers
        for inner, shift in hidden:
            values = np.tanh(values @ inner.mT + shift[:, None])
        moved = (values @ weights.mT + bias[:, None]).mean(axis=0).reshape(guess.shape)
        odds, size = np.moveaxis(guess + MOST_SHIFT * np.tanh(moved / MOST_SHIFT), -1, 0)
        return Outcome(1 / (1 + np.exp(-odds)), np.minimum(np.exp(size), 1.0))

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it; :func:`error_model_from` reads it."""
        layers = [{"weights": weights.tolist(), "bias": bias.tolist()} for weights, bias in self.layers]
        return {"mean": self.mean.tolist(), "scale": self.scale.tolist(), "layers": layers}


def transformed(guess: Outcome) -> Array:
    """Return (2,) what is shifted: the log-odds of a guess's chance of no volume, and the logarithm of how far off one is."""
    chance = np.clip(guess.missed, LEAST_CHANCE, 1 - LEAST_CHANCE)
    return np.stack([np.log(chance / (1 - chance)), np.log(np.maximum(guess.off, LEAST_CHANCE))], axis=-1)


def error_model_from(content: dict[str, Any]) -> ErrorModel:
    """Return the model of :meth:`ErrorModel.to_dict`.

    Raises:
        ValueError: If there are no layers.
    """
    layers = tuple((np.array(each["weights"]), np.array(each["bias"])) for each in content["layers"])
    if not layers:
        raise ValueError("no layers")
    return ErrorModel(np.array(content["mean"]), np.array(content["scale"]), layers)


@cache
def shipped_error_model() -> ErrorModel:
    """Return the one that comes with the package.

    Raises:
        ModelError: If its file is missing or broken.
    """
    return packaged(FILE, error_model_from)

"""Drawing parameters: a recipe says what it draws in one word, and every draw comes from the caller's generator."""

import numpy as np


class Dice:
    """The few distributions that the recipes use."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._random = rng.random

    def between(self, low: float, high: float) -> float:
        """Return a number uniform in [low, high)."""
        return float(low + (high - low) * self._random())

    def count(self, low: int, high: int) -> int:
        """Return a whole number uniform in low, ..., high."""
        return low + int((high - low + 1) * self._random())

    def chance(self, share: float) -> bool:
        """Return True with the given probability."""
        return bool(self._random() < share)

    def pick(self, **weights: float) -> str:
        """Return one of the names, with probability proportional to its weight."""
        left = sum(weights.values()) * self._random()
        name = ""
        for name, weight in weights.items():  # noqa: B007 - the last name is the answer if rounding leaves a rest
            left -= weight
            if left < 0:
                break
        return name

"""One interface for everything that a view can be worth: objective x what is known -> one number per candidate view.

To add an objective, write one file with a class that has a name and :meth:`Objective.gains`, and name it in ``gain/__init__.py``.
"""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError

K = TypeVar("K")
Known = TypeVar("Known", contravariant=True)


class Objective(Protocol[Known]):
    """What each candidate view of a rig is worth, given what is known: the higher the better."""

    @property
    def name(self) -> str:
        """Name for tables, manifests and recipes."""
        ...

    def gains(self, known: Known) -> Vector:
        """Return the (V,) worth of the candidates, in rig order, all finite."""
        ...


@dataclass(frozen=True, slots=True)
class Choice(Generic[K]):
    """Another objective as a choice: one number for its best view, another for all the rest. Of equal views the first is best.

    Source:
        With 1 and 0, the one-hot target of the source paper, section 3; 0.8 and 0.2 are in the authors' public label scripts.
    """

    objective: Objective[K]
    """Whose best view is chosen."""
    best: float = 1.0
    """Score of that view."""
    others: float = 0.0
    """Score of each other view."""

    def __post_init__(self) -> None:
        if not (np.isfinite([self.best, self.others]).all() and self.best > self.others):
            raise ConfigError(f"choice: got {self.best} for the best view and {self.others} for others, wanted more for the best")

    @property
    def name(self) -> str:
        """The objective's name and the two numbers."""
        return f"{self.objective.name}: {self.best:g} or {self.others:g}"

    def gains(self, known: K) -> Vector:
        """Return the (V,) choice."""
        scores = self.objective.gains(known)
        chosen = np.full(len(scores), self.others)
        chosen[np.argmax(scores)] = self.best
        return chosen


@dataclass(frozen=True, slots=True)
class Weighted(Generic[K]):
    """A weighted sum of objectives about the same known things. A weight of 0 switches a term off."""

    terms: tuple[tuple[float, Objective[K]], ...]
    """Weights and objectives, at least one."""

    def __post_init__(self) -> None:
        if not self.terms or not np.all(np.isfinite([weight for weight, _ in self.terms])):
            raise ConfigError(f"weighted objective: got {len(self.terms)} terms, wanted one or more with finite weights")

    @property
    def name(self) -> str:
        """The terms that count, with their weights."""
        return " + ".join(f"{weight:g} {objective.name}" for weight, objective in self.terms if weight) or "nothing"

    def gains(self, known: K) -> Vector:
        """Return the (V,) sums; a term that is switched off is not even asked, but the first is, for the number of views."""
        first, *others = self.terms
        total = first[0] * first[1].gains(known)
        for weight, objective in others:
            if weight:
                total = total + weight * objective.gains(known)
        return total

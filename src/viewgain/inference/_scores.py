"""What a network says of every candidate view, and whoever can be asked for it about a cloud."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewgain.arrays import Points, Vector
from viewgain.inference._card import FrameName, ModelCard
from viewgain.inference._normalise import Bounds


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """What a network says of every candidate view."""

    scores: Vector
    """(V,) the higher the better, in the card's order."""
    sigma: Vector | None
    """(V,) standard deviation of each, where the network gives one."""

    @classmethod
    def of(cls, output: NDArray[Any]) -> "Scores":
        """Return what a network's output for one cloud means: (1, V) scores, or (1, V, 2) with logarithms of their variance."""
        if output.ndim == 2:
            return cls(output[0].astype(float), None)
        return cls(output[0, :, 0].astype(float), np.exp(0.5 * output[0, :, 1].astype(float)))


class CloudScorer(ABC):
    """One network, or several asked together, that scores the views of a rig from a cloud of the object."""

    @property
    @abstractmethod
    def card(self) -> ModelCard:
        """What it is for."""

    @abstractmethod
    def refusal(self, *, frame: FrameName | None = None, rig: str | None = None) -> str | None:
        """Return why it does not fit, or None.

        Args:
            frame: Where the points that it would get are given; None for where it wants them.
            rig: Name of the rig whose candidates are to be ranked; None for its own.
        """

    @abstractmethod
    def assessed(
        self,
        points: Points,
        view_state: ArrayLike | None = None,
        *,
        bounds: Bounds | None = None,
        frame: FrameName | None = None,
        seed: int = 0,
    ) -> Scores:
        """Return the scores of a cloud, normalised by the card's rule and thinned to its number of points.

        Args:
            points: (n, 3) the object without its floor, in the card's frame, in any unit.
            view_state: (V,) true for visited views, in rig order; None for networks that are not told.
            bounds: Box of the whole object (rule ``whole_box``); None says that the points are normalised already.
            frame: Where the points are given; None for the card's.
            seed: Of the thinning.

        Raises:
            ScanError: If there are no points, or some are not finite.
            ConfigError: If the frame does not fit, the view state is missing or not wanted, or the points reach too far.
        """

    def scores(
        self,
        points: Points,
        view_state: ArrayLike | None = None,
        *,
        bounds: Bounds | None = None,
        frame: FrameName | None = None,
        seed: int = 0,
    ) -> Vector:
        """Return (V,) scores of a cloud in the card's order; arguments and errors as :meth:`assessed`."""
        return self.assessed(points, view_state, bounds=bounds, frame=frame, seed=seed).scores

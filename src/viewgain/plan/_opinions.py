"""What is known of every candidate when a view for the volume is chosen: what model and network say, and whom to believe."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Mask, Vector
from viewgain.errors import ConfigError


@dataclass(frozen=True, slots=True, eq=False)
class Opinions:
    """Two opinions of the same candidates."""

    model: Vector
    """(V,) expected relative volume errors by the model; NaN where it has no opinion."""
    network: Vector
    """(V,) the same by a network; NaN where it has none."""
    trust: float
    """Weight of the model (:func:`viewgain.plan.trust`)."""
    reachable: Mask
    """(V,) candidates that can be chosen."""

    def __post_init__(self) -> None:
        shapes = {each.shape for each in (self.model, self.network, self.reachable)}
        if len(shapes) != 1 or self.model.ndim != 1 or not 0 <= self.trust <= 1:
            raise ConfigError(f"opinions: got shapes {shapes} and trust {self.trust}, wanted one (V,) and a weight of 0 to 1")

    @property
    def both(self) -> Vector:
        """(V,) their weighted mean; where one of the two has no opinion the other's."""
        return weighted(self.model, self.network, self.trust)


def weighted(one: Vector, two: Vector, weight: float) -> Vector:
    """Return (V,) means with a weight of the first; where one is NaN, the other."""
    mean = weight * one + (1 - weight) * two
    return np.where(np.isnan(one), two, np.where(np.isnan(two), one, mean))

"""The grid: log odds of occupancy per voxel, and what follows from them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Ids, Mask, Vector
from viewgain.errors import ConfigError
from viewgain.voxels._evidence import Evidence
from viewgain.voxels._lattice import Lattice


@dataclass(frozen=True, slots=True, kw_only=True)
class OccupancyModel:
    """How strongly a scan speaks. A voxel nobody has spoken of has probability 0.5."""

    hit: float = 0.7
    """Probability of being occupied after one hit."""
    miss: float = 0.4
    """Probability of being occupied after one ray through it."""
    least: float = 0.1192
    """No voxel is believed to be freer than this."""
    most: float = 0.971
    """No voxel is believed to be more surely occupied than this."""

    def __post_init__(self) -> None:
        if not 0 < self.least <= self.miss < 0.5 < self.hit <= self.most < 1:
            raise ConfigError(
                f"occupancy: got least {self.least}, miss {self.miss}, hit {self.hit}, most {self.most};"
                " wanted 0 < least <= miss < 0.5 < hit <= most < 1"
            )


OCTOMAP = OccupancyModel()
"""The defaults of OctoMap (Hornung et al. 2013), made for many noisy scans."""
CERTAIN = OccupancyModel(hit=0.98, miss=0.02, least=0.01, most=0.99)
"""For few scans without noise: one look settles a voxel. Ours."""


@dataclass(frozen=True, slots=True, eq=False)
class VoxelGrid:
    """What is known of every voxel of a lattice. A value: adding evidence makes another grid."""

    lattice: Lattice
    """Where the voxels lie."""
    log_odds: Vector
    """(count,) ln(p / (1 - p)) of the probability p of being occupied, by flat index; 0 for a voxel never spoken of."""
    observed: Mask
    """(count,) whether any scan has spoken of it."""
    returns: Ids
    """(count,) number of returns in it so far."""
    model: OccupancyModel = OCTOMAP
    """How strongly a scan speaks."""

    @classmethod
    def empty(cls, lattice: Lattice, model: OccupancyModel = OCTOMAP) -> "VoxelGrid":
        """Return the grid of which nothing is known."""
        count = lattice.count
        return cls(lattice, np.zeros(count), np.zeros(count, dtype=bool), np.zeros(count, dtype=np.int32), model)

    def plus(self, scans: Iterable[Evidence]) -> "VoxelGrid":
        """Return the grid after further scans, in their order (with clamping the order matters, if little).

        Source:
            Moravec and Elfes (1985) for the sum of log odds; Hornung et al. (2013), OctoMap, for the clamping.
        """
        log_odds, observed, returns = self.log_odds.copy(), self.observed.copy(), self.returns.copy()
        low, high = _logit(self.model.least), _logit(self.model.most)
        hit, miss = _logit(self.model.hit), _logit(self.model.miss)
        for said in scans:
            log_odds[said.hits] = np.minimum(log_odds[said.hits] + hit, high)
            log_odds[said.passed] = np.maximum(log_odds[said.passed] + miss, low)
            observed[said.hits] = observed[said.passed] = True
            returns[said.hits] += said.returns
        return VoxelGrid(self.lattice, log_odds, observed, returns, self.model)

    @property
    def probability(self) -> Vector:
        """(count,) probability of being occupied; 0.5 for a voxel never spoken of."""
        return np.asarray(1 / (1 + np.exp(-self.log_odds)))

    @property
    def entropy(self) -> Vector:
        """(count,) entropy of that probability in nats: ln 2 for a voxel never spoken of."""
        p = self.probability
        return np.asarray(-p * np.log(p) - (1 - p) * np.log1p(-p))

    @property
    def occupied(self) -> Mask:
        """(count,) more likely occupied than not."""
        return np.asarray(self.log_odds > 0)

    @property
    def free(self) -> Mask:
        """(count,) more likely free than not."""
        return np.asarray(self.log_odds < 0)

    @property
    def unobserved(self) -> Mask:
        """(count,) never spoken of."""
        return np.asarray(~self.observed)


def _logit(probability: float) -> float:
    return float(np.log(probability / (1 - probability)))

"""A real scan with its simulated ones, and the bins in which they are compared: what tables and pictures share."""

from dataclasses import dataclass

import numpy as np

from benchmarks import _tof_measures as measures
from benchmarks._tof_measures import Patches
from benchmarks._tof_views import Case, Look, Setup
from viewgain.scans import Scan

INCIDENCES = np.array([0.0, 10, 20, 30, 40, 50, 60, 70, 80])
"""Edges of the bins of incidence for noise, degrees."""
LOSS_DEG = np.array([0.0, 20, 40, 50, 55, 60, 65, 70, 75])
"""Edges of the bins of incidence for missing returns, degrees."""
EDGE_PX = np.arange(-8.5, 9.0, 1.0)
"""Edges of the bins of distance from the outline, pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """One real scan and its simulated ones."""

    setup: Setup
    scan: Scan
    real: Look
    simulated: list[Look]
    """All effects, one per seed."""
    direct: list[Look]
    """The same without multipath."""

    @property
    def case(self) -> Case:
        """What was asked for."""
        return self.setup.case


def noise_of(pair: Pair) -> tuple[Patches, Patches]:
    """Return the patches of the real scan and of all simulated ones."""
    return measures.noise_patches(pair.real), measures.joined([measures.noise_patches(look) for look in pair.simulated])

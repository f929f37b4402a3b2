"""What is read of the samples that are judged."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Some samples, by what their views are worth; views with the present one first."""

    rows: NDArray[np.intp]
    """(N,) indices in the data set."""
    objects: NDArray[np.int64]
    """(N,) number of the object."""
    gains: Array
    """(N, V) share of the surface that each view adds."""
    free: NDArray[np.bool_]
    """(N, V) views that were not visited yet."""


def read_judged(data: Dataset, rows: NDArray[np.intp], target: str) -> Judged:
    """Return what some samples' views are worth by a target.

    Raises:
        ConfigError: If the data set has no such target.
    """
    if target not in data.manifest.targets:
        known = ", ".join(data.manifest.targets) or "none"
        raise ConfigError(f"{data.folder}: got target {target!r}, wanted one that the data set has: {known}")
    views = len(data[0].state) if len(data) else 0
    gains, free = np.zeros((len(rows), views)), np.zeros((len(rows), views), dtype=bool)
    for place, index in enumerate(rows.tolist()):
        sample = data[index]
        gains[place], free[place] = sample.targets[target], ~np.asarray(sample.state, dtype=bool)
    return Judged(rows, data.column("object")[rows].astype(np.int64), gains, free)

"""Which samples of a data set a table is about, and what is read of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError

SPLITS = {
    "same_category": "new objects of seen categories",
    "other_category": "objects of unseen categories",
}
"""What is judged under each division's name, in words."""


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


def judged_rows(data: Dataset, split: str) -> NDArray[np.intp]:
    """Return the samples that the shipped training recipes leave out, first steps only.

    ``same_category``: its part ``test``, of categories that train. ``other_category``: all of the categories that do not.

    Raises:
        ConfigError: If the data set has no such division.
    """
    rows = data.part(split, "test")
    if split == "same_category" and "other_category" in data.manifest.tables.splits:
        rows = np.intersect1d(rows, data.part("other_category", "train"))
    return _first_steps(data, rows)


def learned_rows(data: Dataset) -> NDArray[np.intp]:
    """Return the samples that are in part ``train`` of every division, first steps only."""
    rows = np.arange(len(data))
    for split in data.manifest.tables.splits:
        rows = np.intersect1d(rows, data.part(split, "train"))
    return _first_steps(data, rows)


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


def _first_steps(data: Dataset, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    first: NDArray[np.intp] = rows[data.column("step")[rows] == 0]
    return first

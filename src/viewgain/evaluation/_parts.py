"""Which samples of a data set a table is about."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from viewgain.datasets import Dataset, Plan, Unit
from viewgain.errors import ConfigError, DataError

SEEN, UNSEEN = "same_category", "other_category"
"""Names of the divisions."""
SPLITS = {
    SEEN: "new objects of seen categories",
    UNSEEN: "objects of unseen categories",
}
"""What is judged under each division's name, in words."""
FRESH = {SEEN: "fresh objects of seen categories", UNSEEN: "fresh objects of unseen categories"}
"""The same of objects that were made for the evaluation."""
MESHES = "meshes"
"""Name of the part that meshes given by the user are."""
_MESHES = "meshes given: no network may have seen them"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """Some samples to judge, first steps only, and those that a floor may learn from."""

    name: str
    """A key of :data:`SPLITS`, or :data:`MESHES`."""
    title: str
    """What it is, in words."""
    rows: NDArray[np.intp]
    """(N,) indices in the data set."""
    learned: NDArray[np.intp]
    """(M,) samples that train; none where the data set is not what networks were trained on."""


def trained_parts(data: Dataset, split: str | None = None) -> tuple[Part, ...]:
    """Return what the shipped training recipes leave out of a data set, by division; those that hold something.

    ``same_category``: its part ``test``, of categories that train. ``other_category``: all of the categories that do not. What
    trains is in part ``train`` of every division.

    Args:
        data: The data set that networks were trained on.
        split: Only this division; None for each that there is.

    Raises:
        ConfigError: If the data set has no such division.
        DataError: If nothing is left to judge.
    """
    there = data.manifest.tables.splits
    learned = np.arange(len(data))
    for name in there:
        learned = np.intersect1d(learned, data.part(name, "train"))
    parts = []
    for name in [each for each in SPLITS if each in there] if split is None else [split]:
        rows = data.part(name, "test")
        if name == "same_category" and "other_category" in there:
            rows = np.intersect1d(rows, data.part("other_category", "train"))
        parts.append(_part(data, name, SPLITS.get(name, name), rows, learned))
    return _filled(data, parts)


def fresh_parts(data: Dataset, split: str | None = None) -> tuple[Part, ...]:
    """Return all samples of fresh objects (:func:`viewgain.evaluation.fresh_plan`): of categories that train, and of the others.

    Raises:
        ConfigError: If there is no such division.
        DataError: If nothing is left to judge.
    """
    sides = {"same_category": "train", "other_category": "test"}
    if split is not None and split not in sides:
        raise ConfigError(f"fresh objects: got division {split!r}, wanted {' or '.join(sides)}")
    none = np.zeros(0, dtype=np.intp)
    chosen = sides if split is None else {split: sides[split]}
    return _filled(data, [_part(data, n, FRESH[n], data.part("other_category", s), none) for n, s in chosen.items()])


def mesh_parts(data: Dataset) -> tuple[Part, ...]:
    """Return all samples of given meshes as one part.

    Raises:
        DataError: If there are none.
    """
    return _filled(data, [_part(data, MESHES, _MESHES, np.arange(len(data)), np.zeros(0, dtype=np.intp))])


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitPart:
    """Some objects to judge."""

    name: str
    """As of :class:`Part`."""
    title: str
    """What it is, in words."""
    units: tuple[Unit, ...]
    """The objects."""


def unit_parts(plan: Plan, source: Literal["data", "fresh", "meshes"]) -> tuple[UnitPart, ...]:
    """Return the objects of a plan by part, as :func:`trained_parts`, :func:`fresh_parts` and :func:`mesh_parts` do its samples.

    Raises:
        DataError: If nothing is left to judge.
    """
    if source == "meshes":
        return (UnitPart(name=MESHES, title=_MESHES, units=plan.units),)
    seen = tuple(each for each in plan.units if each.splits["other_category"] == "train")
    unseen = tuple(each for each in plan.units if each.splits["other_category"] == "test")
    if source == "data":
        seen = tuple(each for each in seen if each.splits["same_category"] == "test")
    titles = FRESH if source == "fresh" else SPLITS
    parts = [
        UnitPart(name=name, title=titles[name], units=units) for name, units in zip(SPLITS, (seen, unseen), strict=True) if units
    ]
    if not parts:
        raise DataError(f"{plan.recipe.name}: got no object in a test part; build coverage data with more objects")
    return tuple(parts)


def _part(data: Dataset, name: str, title: str, rows: NDArray[np.intp], learned: NDArray[np.intp]) -> Part:
    steps = data.column("step")
    return Part(name=name, title=title, rows=rows[steps[rows] == 0], learned=learned[steps[learned] == 0])


def _filled(data: Dataset, parts: list[Part]) -> tuple[Part, ...]:
    filled = tuple(part for part in parts if len(part.rows))
    if not filled:
        names = " or ".join(part.name for part in parts) or " or ".join(SPLITS)
        raise DataError(f"{data.folder}: got no sample to judge in division {names}; build coverage data with more objects")
    return filled

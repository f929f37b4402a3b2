"""A unit of work: what one process makes without asking anyone. A shard is a fixed group of units."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.datasets._sample import Sample
from viewgain.scans import Scan

Masks: TypeAlias = dict[int, NDArray[np.uint8]]
"""By object: (V, bytes) which surface points each view covers, one bit each, as ``np.packbits`` packs them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """One mesh, or some scans of one box from one station."""

    number: int
    """Place among all units."""
    object: int
    """Number of the box or mesh."""
    name: str
    """For messages and the list of what was skipped."""
    category: str
    """Category of the object."""
    splits: Mapping[str, str] = field(default_factory=dict)
    """Parts that all its samples belong to."""
    source: Any = None
    """What the maker needs to know: a mesh's entry, a range of captures, scan files. Any value that can be sent to a process."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Skipped:
    """What could not be made, and why."""

    unit: int
    name: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """What came of a unit."""

    samples: tuple[Sample, ...]
    skipped: tuple[Skipped, ...] = ()
    masks: Masks = field(default_factory=dict)


class Maker(Protocol):
    """Makes the samples of a unit; the same bits for the same recipe and unit, wherever it runs."""

    def units(self) -> Iterator[Unit]:
        """Yield all units in order, without making anything."""

    def make(self, unit: Unit) -> Made:
        """Return the samples of a unit. A :class:`ViewgainError` becomes the reason why the whole unit is skipped."""

    def scans(self, unit: Unit) -> Iterator[tuple[Sample | Skipped, Scan | None]]:
        """Yield each sample with the whole scan behind it, for estimators; raises ConfigError where there are no such scans."""

"""Reading a data set: any sample at once, straight from the memory map."""

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets._columns import unpacked
from viewgain.datasets._manifest import ERRORS, SHARDS, Manifest, read_manifest
from viewgain.datasets._sample import Sample
from viewgain.datasets._tensors import Columns, opened
from viewgain.datasets._work import MASK_BITS, MASK_OBJECT
from viewgain.errors import ConfigError, DataError

_MOST_OPEN = 512
"""Shards that are kept open at a time; each takes one file descriptor."""


class Dataset:
    """A data set on disk, as a sequence of samples."""

    def __init__(self, folder: Path | str) -> None:
        """Read the manifest; shards are opened when they are first needed.

        Raises:
            DataError: If there is no finished data set in the folder.
        """
        self.folder = Path(folder)
        self.manifest: Manifest = read_manifest(self.folder)
        self._ends = np.cumsum([shard.samples for shard in self.manifest.shards]).tolist()
        self._shard = lru_cache(maxsize=_MOST_OPEN)(self._open)
        self._scores: dict[str, Mapping[int, Array]] = {}

    def with_scores(self, name: str, scores: Mapping[int, Array]) -> "Dataset":
        """Return the same data set with a further target that is the same for all samples of an object.

        Args:
            name: What to call it.
            scores: (V,) scores by object, in rig order; each sample gets them with its present view first.
        """
        other = Dataset(self.folder)
        other._scores = {**self._scores, name: scores}
        return other

    def __getstate__(self) -> dict[str, object]:
        """Leave the memory maps behind: another process opens its own."""
        return {"folder": self.folder, "_scores": self._scores}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Open the data set again."""
        self.__init__(state["folder"])  # type: ignore[misc]  # a fresh start is what is wanted
        self._scores = state["_scores"]

    def __len__(self) -> int:
        return int(self._ends[-1]) if self._ends else 0

    def __getitem__(self, index: int) -> Sample:
        """Return one sample: float32 points, everything else a view of the file.

        Raises:
            IndexError: If there is no such sample.
            DataError: If its shard is missing or its header damaged; ``viewgain dataset verify`` looks at the content too.
        """
        number, row = self._place(index)
        sample = unpacked(self._shard(number), row, self.manifest.tables, self.manifest.frame, self.manifest.targets)
        if not self._scores:
            return sample
        further = {name: np.roll(scores[sample.object], -sample.view) for name, scores in self._scores.items()}
        return replace(sample, targets={**sample.targets, **further})

    def __iter__(self) -> Iterator[Sample]:
        return (self[index] for index in range(len(self)))

    def column(self, name: str) -> NDArray[np.generic]:
        """Return a column of numbers over all samples, for instance ``object``, ``view``, ``capture``, ``coverage`` or ``dims``.

        Raises:
            ConfigError: If there is no such column with one row per sample.
        """
        shards = [self._shard(number) for number in range(len(self.manifest.shards))]
        if any(
            name not in shard or len(shard[name]) != entry.samples
            for shard, entry in zip(shards, self.manifest.shards, strict=True)
        ):
            raise ConfigError(
                f"column: got {name!r}, wanted one with a row per sample, such as object, view, capture or coverage"
            )
        return np.concatenate([shard[name] for shard in shards])

    def part(self, split: str, part: str) -> NDArray[np.intp]:
        """Return the indices of the samples that a division puts into a part: ``part("other_box", "test")``.

        Raises:
            ConfigError: If there is no such division or part.
        """
        tables = self.manifest.tables
        if split not in tables.splits or part not in tables.parts:
            raise ConfigError(
                f"got division {split!r}, part {part!r}; wanted {' or '.join(tables.splits)}, {' or '.join(tables.parts)}"
            )
        return np.flatnonzero(self.column("split")[:, tables.splits.index(split)] == tables.parts.index(part))

    def masks(self, number: int) -> NDArray[np.uint8]:
        """Return the (V, bytes) surface points that each view of an object covers, one bit each, views in rig order.

        Raises:
            ConfigError: If none are stored for that object.
        """
        for shard in range(len(self.manifest.shards)):
            columns = self._shard(shard)
            if MASK_OBJECT in columns and number in columns[MASK_OBJECT]:
                return np.asarray(columns[MASK_BITS][columns[MASK_OBJECT] == number])
        raise ConfigError(f"{self.folder}: got object {number}, and no masks are stored for it")

    def volume_errors(self, estimator: str) -> Array:
        """Return the (n,) relative volume errors V / V* - 1 of every sample's whole scan by an estimator; NaN for no estimate.

        Raises:
            DataError: If they have not been worked out (``viewgain dataset build --resume --errors``), or not for every shard.
        """
        folder = self.folder / ERRORS / estimator
        parts = []
        for entry in self.manifest.shards:
            path = folder / entry.name
            if not path.exists():
                raise DataError(f"{folder}: has no errors for {entry.name}; run its build with --resume --errors {estimator}")
            columns, metadata = opened(path)
            if metadata.get("shard_sha256") != entry.sha256 or len(columns["error"]) != entry.samples:
                raise DataError(f"{path}: is of another data set; run its build with --resume --errors {estimator}")
            parts.append(columns["error"])
        return np.concatenate(parts).astype(float)

    def _place(self, index: int) -> tuple[int, int]:
        count = len(self)
        if not -count <= index < count:
            raise IndexError(f"got sample {index} of {count}")
        index %= count
        number = bisect_right(self._ends, index)
        return number, index - (self._ends[number - 1] if number else 0)

    def _open(self, number: int) -> Columns:
        entry = self.manifest.shards[number]
        columns, metadata = opened(self.folder / SHARDS / entry.name)
        if metadata.get("plan") != self.manifest.plan or len(columns["view"]) != entry.samples:
            raise DataError(f"{self.folder / SHARDS / entry.name}: is of another data set; run its build with --resume")
        return columns

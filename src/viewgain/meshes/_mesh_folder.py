"""A folder of meshes by category: listed once, in an order that never changes, and divided by category and never by mesh.

Meshes of one category are often variants of a few, so a division by mesh would test on what it trained on.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from viewgain.errors import ConfigError
from viewgain.meshes._entry import MeshEntry
from viewgain.meshes._file import PathLike
from viewgain.meshes._layouts import find_entries


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshFolder:
    """The meshes of a folder, or some of them. None is read before :meth:`MeshEntry.load` is called."""

    root: Path
    layout: str
    """ "folder", "shapenet1", "shapenet2" or "modelnet"."""
    entries: tuple[MeshEntry, ...]
    """By category, then name."""

    @classmethod
    def open(cls, root: PathLike, *, layout: str = "auto") -> "MeshFolder":
        """Return the meshes of a folder; docs/meshes.md has the layouts.

        Raises:
            ConfigError: If there is no such layout, or "auto" finds several.
            MeshError: If the folder is missing, cannot be read, or holds no mesh; the message lists what was looked for.
        """
        root = Path(root)
        found, entries = find_entries(root, layout)
        return cls(root=root, layout=found, entries=entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[MeshEntry]:
        return iter(self.entries)

    def __getitem__(self, index: int) -> MeshEntry:
        return self.entries[index]

    @property
    def categories(self) -> tuple[str, ...]:
        """The names of the categories, sorted."""
        return tuple(sorted({entry.category for entry in self.entries}))

    def only(self, categories: Iterable[str]) -> "MeshFolder":
        """Return the meshes of these categories.

        Raises:
            ConfigError: If there is no such category.
        """
        wanted = self._known(categories)
        return replace(self, entries=tuple(entry for entry in self.entries if entry.category in wanted))

    def without(self, categories: Iterable[str]) -> "MeshFolder":
        """Return the meshes of all other categories; raises as :meth:`only`."""
        unwanted = self._known(categories)
        return replace(self, entries=tuple(entry for entry in self.entries if entry.category not in unwanted))

    def part(self, name: str) -> "MeshFolder":
        """Return the meshes that the data set itself puts into "train" or "test" (ModelNet, by mesh).

        Raises:
            ConfigError: If the data set has no such part.
        """
        entries = tuple(entry for entry in self.entries if entry.part == name)
        if not entries:
            parts = sorted({entry.part for entry in self.entries if entry.part is not None})
            raise ConfigError(f"part: got {name!r}, and {self.root} has {' and '.join(parts) or 'no parts'}; use split instead")
        return replace(self, entries=entries)

    def split(self, **parts: Iterable[str]) -> dict[str, "MeshFolder"]:
        """Return the parts, each with its categories: ``split(train=["chair", "car"], test=["lamp"])``. Others are left out.

        Raises:
            ConfigError: If a category is in two parts or is not there.
        """
        chosen = {part: self._known(categories) for part, categories in parts.items()}
        named = [category for categories in chosen.values() for category in sorted(categories)]
        twice = sorted({category for category in named if named.count(category) > 1})
        if twice:
            raise ConfigError(f"split: {', '.join(twice)} is in more than one part; name each category once")
        return {part: self.only(categories) for part, categories in chosen.items()}

    def random_split(self, *, rng: np.random.Generator, **shares: float) -> dict[str, "MeshFolder"]:
        """Return parts of randomly chosen categories: ``random_split(rng=rng, train=0.8, test=0.2)``; each mesh is in one.

        The shares are of the number of categories, rounded.

        Raises:
            ConfigError: If the shares are not positive or do not add up to 1, or a part would be left without a category.
        """
        values = np.array(list(shares.values()), dtype=float)
        if not len(values) or not np.all(values > 0) or abs(values.sum() - 1) > 1e-9:
            raise ConfigError(f"random_split: got the shares {shares}, wanted positive ones that add up to 1")
        ends = [0, *np.round(np.cumsum(values) * len(self.categories)).astype(int).tolist()]
        if any(start == end for start, end in pairwise(ends)):
            raise ConfigError(f"random_split: {len(self.categories)} categories are too few for the shares {shares}")
        shuffled = rng.permutation(np.array(self.categories, dtype=object)).tolist()
        return self.split(**{part: shuffled[start:end] for part, (start, end) in zip(shares, pairwise(ends), strict=True)})

    def _known(self, categories: Iterable[str]) -> set[str]:
        wanted = {categories} if isinstance(categories, str) else set(categories)
        unknown = sorted(wanted - set(self.categories))
        if unknown:
            raise ConfigError(
                f"categories: {', '.join(unknown)} not among the {len(self.categories)}: {', '.join(self.categories)}"
            )
        return wanted

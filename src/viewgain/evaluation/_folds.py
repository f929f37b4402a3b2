"""Choices of held-out boxes: a figure of one choice says little about eleven boxes."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from viewgain.datasets import Dataset
from viewgain.errors import ConfigError


def boxes_of(data: Dataset) -> list[tuple[int, ...]]:
    """Return the objects of each box, by the first of them. Objects of one size are one box, which several cameras have recorded.

    Held out apart, the one would be judged by a network that has learned the other.
    """
    objects, dims = data.column("object").astype(int), np.asarray(data.column("dims"), dtype=float)
    alike: dict[object, list[int]] = {}
    for number in np.unique(objects).tolist():
        size = dims[int(np.argmax(objects == number))]
        alike.setdefault(tuple(size.tolist()) if np.all(np.isfinite(size)) else number, []).append(number)
    return [tuple(numbers) for numbers in alike.values()]


def leave_out(objects: Sequence[int], leave: int, *, most: int | None = None, seed: int = 0) -> list[tuple[int, ...]]:
    """Return the choices of ``leave`` of the objects, each ascending, all of them in a drawn order, or the first ``most``.

    Raises:
        ConfigError: If so many cannot be left out and leave some to train on.
    """
    numbers = sorted(set(objects))
    if not 1 <= leave < len(numbers) or (most is not None and most < 1):
        raise ConfigError(f"folds: got {leave} of {len(numbers)} boxes to leave out, wanted 1 or more, and fewer than there are")
    every = list(combinations(numbers, leave))
    order = np.random.default_rng([seed, 0x666F]).permutation(len(every))
    return [every[place] for place in order[:most].tolist()]

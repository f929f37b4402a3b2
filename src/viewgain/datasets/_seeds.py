"""Seeds: every scene and every scan has a numbered stream of its own, so its bits depend on nothing but the recipe's seed."""

from typing import TypeAlias

import numpy as np

SeedKey: TypeAlias = tuple[int, int, int, int]
"""(object, purpose, view, capture or start): the spawn key of the stream, kept with every sample."""
SPLIT, SCENE, SCAN, SURFACE, START, WANDER = range(6)
"""Purposes of a stream."""


def generator(seed: int, key: SeedKey) -> np.random.Generator:
    """Return the generator of one stream: ``default_rng(SeedSequence(seed, spawn_key=key))``."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))

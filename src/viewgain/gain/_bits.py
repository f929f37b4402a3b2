"""Sets of surface points as bits: 64 to a word, so that a union and its size are a few instructions."""

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Mask

Bits: TypeAlias = Annotated[NDArray[np.uint64], "(..., w) one bit per element, 64 to a word"]
Counts: TypeAlias = Annotated[NDArray[np.int64], "(...,) numbers of elements"]


def packed(masks: Mask) -> Bits:
    """Return the (..., ceil(m / 64)) words of (..., m) masks; the bits behind the last element are 0."""
    octets = np.packbits(masks, axis=-1, bitorder="little")
    padding = [(0, 0)] * (octets.ndim - 1) + [(0, -octets.shape[-1] % 8)]
    return np.ascontiguousarray(np.pad(octets, padding)).view("<u8").astype(np.uint64, copy=False)


def unpacked(bits: Bits, count: int) -> Mask:
    """Return the (..., count) masks of (..., w) words."""
    octets = np.ascontiguousarray(bits).astype("<u8", copy=False).view(np.uint8)
    return np.unpackbits(octets, axis=-1, count=count, bitorder="little").astype(bool)


def size(bits: Bits) -> Counts:
    """Return the (...,) number of elements in the sets of (..., w) words."""
    return np.asarray(np.bitwise_count(bits).sum(axis=-1, dtype=np.int64))

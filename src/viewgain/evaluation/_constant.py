"""The constant answer: always the same number of views on from the present one. What it was chosen on matters."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from viewgain.arrays import Array
from viewgain.evaluation._judged import Judged
from viewgain.gain import constant_offset, hits, shortfall

Chosen: TypeAlias = Literal["training", "two_fold"]
"""On the training samples; or on each half of the judged objects for the other half, which then knows what networks do not:
objects of the very categories that are judged."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Constant:
    """A constant answer."""

    hits: Array
    """(N, 5) whether it is within each limit on the judged samples."""
    chosen: Chosen
    """How it was chosen."""
    samples: int
    """On how many samples."""
    offsets: tuple[int, ...]
    """Views from the present one: one, or one per half."""


def constant_answer(judged: Judged, learned: Judged, *, rng: np.random.Generator) -> Constant | None:
    """Return the constant answer chosen on training samples, or where there are none on the other half of the judged objects.

    Args:
        judged: What it is judged on.
        learned: Training samples, or none.
        rng: Draws the halves.

    Returns:
        None where there is neither a training sample nor a second object.
    """
    if len(learned.rows):
        offset = constant_offset(learned.gains, learned.free)
        return Constant(
            hits=_hits(judged, np.full(len(judged.rows), offset)), chosen="training", samples=len(learned.rows), offsets=(offset,)
        )
    objects = np.unique(judged.objects)
    if len(objects) < 2:
        return None
    first = np.isin(judged.objects, rng.permutation(objects)[: len(objects) // 2])
    on_first, on_second = (constant_offset(judged.gains[half], judged.free[half]) for half in (first, ~first))
    return Constant(
        hits=_hits(judged, np.where(first, on_second, on_first)),
        chosen="two_fold",
        samples=len(judged.rows),
        offsets=(on_first, on_second),
    )


def _hits(judged: Judged, offsets: Array) -> Array:
    return hits(shortfall(judged.gains, offsets, judged.free)).astype(float)

"""Greedy choice of views by plain set union: each next view is the one that covers the most samples not covered yet."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices
from viewgain.errors import ConfigError
from viewgain.gain._bits import Bits, size


@dataclass(frozen=True, slots=True, eq=False)
class UnionGreedy:
    """A greedy sequence of views by union."""

    order: Indices
    """(steps,) the views chosen after the first."""
    gains: Array
    """(steps, V) share of the surface that each view would add at each step."""
    coverage: Array
    """(steps + 1,) share covered by the first view, and after each step."""


def greedy_union(masks: Bits, surface_count: int, *, first: int, steps: int) -> UnionGreedy:
    """Return the greedy sequence of ``steps`` views after ``first``.

    Of equal gains the lowest view wins; where no view adds anything, that is view 0 again and again, as in the published rule.

    Args:
        masks: (V, w) what each view covers, bit-packed.
        surface_count: Number of samples the shares are of.
        first: The view that is there from the start.
        steps: How many views follow, >= 1.

    Raises:
        ConfigError: If there is no such first view, or no step.
    """
    require_start(first, steps, len(masks))
    covered = masks[first].copy()
    order, gains = np.empty(steps, dtype=np.intp), np.empty((steps, len(masks)))
    coverage = [int(size(covered))]
    for step in range(steps):
        added = size(masks & ~covered)
        order[step] = np.argmax(added)
        gains[step] = added / surface_count
        covered |= masks[order[step]]
        coverage.append(coverage[-1] + int(added[order[step]]))
    return UnionGreedy(order, gains, np.array(coverage) / surface_count)


def require_start(first: int, steps: int, views: int) -> None:
    """Raise ConfigError unless ``first`` is one of ``views`` views and there is a step to make."""
    if not 0 <= first < views or steps < 1:
        raise ConfigError(
            f"coverage: got first view {first} of {views} and {steps} steps, wanted one of the views and 1 step or more"
        )

"""Coverage as one would first write it: every distance, every cloud accumulated point by point."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def near(a: Array, b: Array, reach: float) -> NDArray[np.bool_]:
    """Return the (n, m) table of which of (n, 3) and (m, 3) points are nearer than the reach."""
    table = np.zeros((len(a), len(b)), dtype=bool)
    for i, (x, y, z) in enumerate(a.tolist()):
        for j, (u, v, w) in enumerate(b.tolist()):
            table[i, j] = (x - u) * (x - u) + (y - v) * (y - v) + (z - w) * (z - w) < reach * reach
    return table


def covered_by(points: Array, surface: Array, reach: float) -> NDArray[np.bool_]:
    """Return the (m,) mask of surface samples with a near point."""
    return np.any(near(points, surface, reach), axis=0)


@dataclass(frozen=True)
class Walk:
    """One greedy sequence."""

    order: list[int]
    gains_published: list[list[float]]
    gains_union: list[list[float]]
    coverage_published: list[float]
    coverage_union: list[float]


def walk(
    clouds: Sequence[Array], surface: Array, reach: float, *, first: int, steps: int, rule: str, order: Sequence[int] = ()
) -> Walk:
    """Return the greedy sequence, or that of an order, with the accumulated cloud kept as a cloud as the published scripts do."""
    accumulated, known = clouds[first], covered_by(clouds[first], surface, reach)
    result = Walk([], [], [], [float(np.mean(known))], [float(np.mean(known))])
    for step in range(steps):
        new = [cloud[~np.any(near(cloud, accumulated, reach), axis=1)] for cloud in clouds]
        published = [float(np.mean(covered_by(points, surface, reach))) for points in new]
        union = [float(np.mean(covered_by(cloud, surface, reach) & ~known)) for cloud in clouds]
        gains = published if rule == "published" else union
        best = order[step] if order else max(range(len(clouds)), key=lambda view: (gains[view], -view))
        result.order.append(best)
        result.gains_published.append(published)
        result.gains_union.append(union)
        accumulated, known = np.concatenate([accumulated, new[best]]), known | covered_by(clouds[best], surface, reach)
        result.coverage_published.append(result.coverage_published[-1] + published[best])
        result.coverage_union.append(float(np.mean(known)))
    return result

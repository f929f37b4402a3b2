"""Policies that look at poses alone, and not at what the scans show: the floors that every other policy has to beat."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Indices, Vector
from viewgain.plan._views import Seen


@dataclass(frozen=True, slots=True)
class UniformPolicy:
    """The next in an evenly spread order, fixed before the first scan.

    The order goes around the list of candidates, from the first scan's on, by halves, then quarters, then eighths: 0, 1/2, 1/4,
    3/4, 1/8, 5/8, ... of the way round (van der Corput). In a ring that is the opposite side, then the sides between; in a rig
    that lists its rings one after the other it alternates between them.
    """

    name: str = "uniform"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) scores: 0 for the next of the order that is not visited, -1 for the one after; visited ones come last."""
        first = seen.visited[0] if seen.visited else 0
        order = (spread_order(len(seen.candidates)) + first) % len(seen.candidates)
        order = np.concatenate([order[seen.unvisited[order]], order[~seen.unvisited[order]]])
        scores = np.empty(len(order))
        scores[order] = -np.arange(len(order))
        return scores


@dataclass(frozen=True, slots=True)
class FarthestPolicy:
    """As far as possible from all places where scans were taken."""

    name: str = "farthest"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) distances from each candidate to the nearest of those places, metres, to a nanometre.

        The rounding makes ties of what is equal but for the last bits, so that the lowest index decides on every machine.
        """
        apart = seen.candidates[:, None, :3, 3] - seen.stands[None, :, :3, 3]
        return np.asarray(np.round(np.linalg.norm(apart, axis=2).min(axis=1), 9))


def spread_order(count: int) -> Indices:
    """Return (count,) the indices 0 to count - 1 in the order in which halving visits them: floor(count * v(k)), each once.

    v is van der Corput's sequence in base 2: 0, 1/2, 1/4, 3/4, 1/8, ...
    """
    size = 1 << max(count - 1, 0).bit_length()
    bits = size.bit_length() - 1
    reverse = [int(f"{k:0{bits}b}"[::-1], 2) if bits else 0 for k in range(size)]
    return np.array(list(dict.fromkeys(place * count // size for place in reverse)), dtype=np.intp)

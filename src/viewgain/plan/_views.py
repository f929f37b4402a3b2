"""The general policy: it has seen posed scans and scores the poses that the camera could go to next, whatever is to be found out.

Every episode, of coverage as of volume, asks its policy through this protocol. A policy that thinks about one box
(:class:`viewgain.plan.Policy`) takes part through the adapters of :mod:`viewgain.plan._adapters`.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from viewgain.arrays import Mask, Poses, Vector
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.measure import Measurement
from viewgain.scans import Scan

NEAR = 0.05
"""A candidate nearer than this to where a scan was taken counts as visited, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """All that a policy may know: the scans so far, and the question."""

    scans: tuple[Scan, ...]
    """The scans in the order taken, each with its pose as the camera believes it; one that showed nothing is missing."""
    stands: Poses
    """(k, 4, 4) ``camera_to_world`` of every place where a scan was taken, in that order; the last is the present place."""
    candidates: Poses
    """(V, 4, 4) ``camera_to_world`` of the poses to score."""
    visited: tuple[int, ...]
    """The candidates at whose place a scan was taken, in the order of taking."""
    camera: Intrinsics
    """The camera's image."""
    measured: Measurement | None = None
    """What the scans say together, in the frame of the last, where somebody has worked it out; None: measure them."""

    def __post_init__(self) -> None:
        if not len(self.stands) or not len(self.candidates):
            raise ConfigError(
                f"seen: got {len(self.stands)} stands and {len(self.candidates)} candidates, wanted at least one of each"
            )

    @property
    def unvisited(self) -> Mask:
        """(V,) candidates at whose place no scan was taken."""
        mask = np.ones(len(self.candidates), dtype=bool)
        mask[list(self.visited)] = False
        return mask


@runtime_checkable
class ViewPolicy(Protocol):
    """Scores candidate poses from the scans so far."""

    @property
    def name(self) -> str:
        """Name for tables and JSON."""
        ...

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) scores, the higher the better, comparable within one call only; NaN where there is no opinion."""
        ...


def choose(scores: Vector, allowed: Mask) -> int | None:
    """Return the allowed candidate with the highest score, the lowest index of equal ones; None if none is allowed.

    A NaN loses to every number.

    Args:
        scores: (V,) scores.
        allowed: (V,) candidates that may be chosen.

    Raises:
        ConfigError: If the shapes differ.
    """
    scores, allowed = np.asarray(scores, dtype=float), np.asarray(allowed, dtype=bool)
    if scores.shape != allowed.shape or scores.ndim != 1:
        raise ConfigError(f"choose: got scores {scores.shape} for candidates {allowed.shape}, wanted one score per candidate")
    places = np.flatnonzero(allowed)
    if not places.size:
        return None
    return int(places[np.argmax(np.nan_to_num(scores[places], nan=-np.inf, posinf=np.inf, neginf=-np.inf))])


def visited_among(candidates: Poses, stands: Poses) -> tuple[int, ...]:
    """Return, for every stand that lies within :data:`NEAR` of a candidate, the nearest one, in order and each once.

    Args:
        candidates: (V, 4, 4) ``camera_to_world``.
        stands: (k, 4, 4) ``camera_to_world``.
    """
    centres, places = candidates[:, :3, 3], stands[:, :3, 3]
    apart = np.linalg.norm(places[:, None] - centres[None], axis=2)
    return unique(int(np.argmin(row)) for row in apart if row.min() < NEAR)


def unique(indices: Iterable[int]) -> tuple[int, ...]:
    """Return indices in order, each once."""
    return tuple(dict.fromkeys(indices))

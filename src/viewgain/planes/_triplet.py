"""A box from three segments that are close to each other: the published description's last step, in our reading."""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Vector, Vector3
from viewgain.planes._cloud import Cloud
from viewgain.planes._corners import Corner, meeting_point, refined_corner
from viewgain.planes._lines import Segments
from viewgain.planes._parallel import Planes
from viewgain.planes._settings import Settings

_CHOICES = np.array(list(product((0, 1), repeat=3)))
"""(8, 3) which end of each segment is its near one."""


@dataclass(frozen=True, slots=True, eq=False)
class Triplet:
    """Three segments at right angles whose near ends lie together."""

    segments: Indices
    """(3,) which segments."""
    near: Indices
    """(3,) which end of each, 0 or 1, is the near one."""
    gap: float
    """Mean distance between the near ends, metres."""
    corner: Vector3
    """(3,) where the box's corner is, metres, camera frame."""
    lengths: Vector
    """(3,) side lengths in the order of the segments, metres."""


def best_triplet(segments: Segments, planes: Planes, cloud: Cloud, settings: Settings) -> Triplet | None:
    """Return the triplet whose near ends are closest to each other, with its side lengths; None without one.

    Args:
        segments: All segments; those shorter than ``min_length`` take no part.
        planes: The planes they lie in.
        cloud: The points, for the refinement of the corner.
        settings: ``max_gap`` and ``right_angle`` are the rule; ``method`` says how lengths are read off.
    """
    triples = orthogonal_triples(segments, settings)
    if len(triples) == 0:
        return None
    gaps, choice = near_ends(segments, triples)
    if gaps.min() >= settings.max_gap:
        return None
    support = np.log(segments.support[triples]).sum(axis=1)
    score = np.where(gaps < settings.max_gap, support, -np.inf) if settings.by_support else -gaps
    best = int(np.argmax(score))
    chosen, near = triples[best], _CHOICES[choice[best]]
    ends = segments.ends[chosen]
    corner, lengths = ends[np.arange(3), near].mean(axis=0), segments.lengths[chosen]
    sides = np.unique(segments.planes[chosen])
    if settings.method == "corners" and len(sides) == 3:
        corner = _corner(planes, sides, cloud, settings)
        lengths = np.linalg.norm(ends[np.arange(3), 1 - near] - corner, axis=1)
        lengths = np.array([
            to_partner(length, int(np.setdiff1d(sides, segments.planes[k])[0]), planes, settings)
            for length, k in zip(lengths, chosen, strict=True)
        ])  # fmt: skip
    return Triplet(chosen, near, float(gaps[best]), corner, lengths)


def orthogonal_triples(segments: Segments, settings: Settings) -> Indices:
    """Return the (t, 3) triples of long enough segments at right angles; with ``true_corners`` those of three planes only."""
    long_enough = np.flatnonzero(segments.lengths >= settings.min_length)
    triples = np.array(list(combinations(long_enough, 3)), dtype=np.intp).reshape(-1, 3)
    cosine = np.abs(segments.directions @ segments.directions.T)
    a, b, c = triples.T
    right = np.maximum(np.maximum(cosine[a, b], cosine[b, c]), cosine[c, a]) < settings.right_angle
    if settings.true_corners:
        right &= _of_three_planes(segments.planes[triples].reshape(-1, 6))
    return triples[right]


def _of_three_planes(six: Indices) -> Mask:
    ordered = np.sort(six, axis=1)
    return np.asarray((np.diff(ordered, axis=1) > 0).sum(axis=1) == 2)


def near_ends(segments: Segments, triples: Indices) -> tuple[Vector, Indices]:
    """Return, per triple, the least mean distance between one end of each segment, and which of the 8 choices it is."""
    ends = segments.ends[triples]  # [t, 3 segments, 2 ends, 3]
    near = ends[:, np.arange(3), _CHOICES]  # [t, 8 choices, 3 segments, 3]
    gaps: Array = np.linalg.norm(near - np.roll(near, 1, axis=2), axis=3).mean(axis=2)
    choice = np.argmin(gaps, axis=1)
    return gaps[np.arange(len(triples)), choice], choice


def to_partner(length: float, plane: int, planes: Planes, settings: Settings) -> float:
    """Return the distance from a plane to the parallel one that an edge of this length, starting in it, ends on.

    The length itself where no parallel plane lies within ``partner_reach`` of its end.
    """
    offsets = planes.offsets[planes.direction == planes.direction[plane]]
    apart = np.abs(offsets - planes.offsets[plane])
    nearest = apart[np.argmin(np.abs(apart - length))]
    return float(nearest if abs(nearest - length) < settings.partner_reach and nearest > 0 else length)


def _corner(planes: Planes, sides: Indices, cloud: Cloud, settings: Settings) -> Vector3:
    normals, offsets = planes.each_normal[sides], planes.offsets[sides]
    meeting = meeting_point(normals, offsets)
    if not settings.refine_corner:
        return meeting
    corner = refined_corner(normals, offsets, cloud, settings)
    return meeting if not isinstance(corner, Corner) else corner.position

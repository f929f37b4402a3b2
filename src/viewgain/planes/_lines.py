"""Where two orthogonal planes meet, and along which part of that line both have points (stage 9)."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Points, Vector
from viewgain.planes._cloud import Cloud
from viewgain.planes._ends import half_density_ends, raw_ends
from viewgain.planes._parallel import Planes
from viewgain.planes._settings import Settings

_FEWEST = 5
"""Points of each plane that soft ends need."""


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Pieces of the lines origin + t direction, t from ``low`` to ``high``, on which pairs of planes meet."""

    planes: Indices
    """(s, 2) the two planes."""
    origins: Points
    """(s, 3) the line's point nearest the camera."""
    directions: Points
    """(s, 3) unit vectors."""
    low: Vector
    """(s,) metres."""
    high: Vector
    """(s,) metres; under ``low`` where the two planes' points do not overlap and reversed segments are let through."""
    support: Indices
    """(s,) points of the plane that has fewer of them near the line."""

    def __len__(self) -> int:
        return len(self.low)

    @property
    def lengths(self) -> Vector:
        """(s,) lengths, metres."""
        return np.asarray(np.abs(self.high - self.low))

    @property
    def ends(self) -> Array:
        """(s, 2, 3) the two end points."""
        at = np.stack([self.low, self.high], axis=1)
        return np.asarray(self.origins[:, None] + at[..., None] * self.directions[:, None])


def line_segments(planes: Planes, cloud: Cloud, settings: Settings) -> Segments:
    """Return a segment for every pair of planes at nearly right angles that both have points near their common line.

    A segment is where the two planes' points overlap: from the later of their first points to the earlier of their last.

    Args:
        planes: The refined planes.
        cloud: The points.
        settings: ``forward_only`` drops segments without overlap; ``soft_ends`` decides by distance and density, not by normal.
    """
    cosine = planes.each_normal @ planes.each_normal.T
    pairs = np.argwhere(np.triu(np.abs(cosine) < settings.crossing, 1))
    origins, directions = meeting_lines(planes, pairs)
    heights = planes.heights(cloud.points)
    member = _members(planes, cloud, heights, settings)
    area = _areas(planes, cloud)
    spans, support = np.full((len(pairs), 2), np.nan), np.zeros(len(pairs), dtype=np.intp)
    for k, pair in enumerate(pairs):
        seen = pair[pair < planes.seen]
        near = np.einsum("np,np->n", heights[:, pair], heights[:, pair]) < settings.line_band**2
        sets = [near & member[:, plane] for plane in seen]
        if settings.convex_only and not _is_convex(planes, pair, heights, sets):
            continue
        support[k] = min(np.count_nonzero(own) for own in sets)
        if support[k] >= (_FEWEST if settings.soft_ends else 1):
            along = cloud.points @ directions[k]
            spans[k] = _edge(along, sets, area[:, seen], settings) if settings.soft_ends else _overlap(along, sets)
    found = np.isfinite(spans[:, 0]) & ((spans[:, 1] > spans[:, 0]) | (not settings.forward_only))
    low, high = spans[found].T
    return Segments(pairs[found], origins[found], directions[found], low, high, support[found])


def meeting_lines(planes: Planes, pairs: Indices) -> tuple[Points, Points]:
    """Return the point nearest the origin, and the unit direction, of the line where each of (s, 2) pairs of planes meets."""
    (one, other), (d, e) = planes.each_normal[pairs].transpose(1, 0, 2), planes.offsets[pairs].T[..., None]
    cosine = np.einsum("sk,sk->s", one, other)[:, None]
    across = np.cross(one, other)
    origins = (-d * one - e * other + cosine * (e * one + d * other)) / (1 - cosine**2)
    return origins, across / np.linalg.norm(across, axis=1, keepdims=True)


def _members(planes: Planes, cloud: Cloud, heights: Array, settings: Settings) -> Mask:
    """Return the (n, m) mask of points that belong to planes: by their normals, or to the nearest one if that is near."""
    if not settings.soft_ends:
        return np.asarray((np.abs(cloud.normals @ planes.normals.T) > settings.gate)[:, planes.direction])
    off = np.abs(heights[:, : planes.seen])
    nearest = off.min(axis=1, initial=np.inf)
    return np.asarray((off == nearest[:, None]) & (off < settings.band))


def _is_convex(planes: Planes, pair: Indices, heights: Array, sets: list[Mask]) -> bool:
    """Return whether the points of each plane lie behind the other: a box's edge, not the foot of its side on the floor."""
    if len(sets) < 2 or not (sets[0].any() and sets[1].any()):
        return True
    towards_camera = np.where(planes.offsets[pair] < 0, -1.0, 1.0)
    return bool(
        heights[sets[0], pair[1]].mean() * towards_camera[1] < 0 and heights[sets[1], pair[0]].mean() * towards_camera[0] < 0
    )


def _areas(planes: Planes, cloud: Cloud) -> Array:
    """Return the (n, m) area a point's pixel covers on each plane, in square metres per solid angle."""
    distance = np.linalg.norm(cloud.points, axis=1)
    cosine = np.abs(cloud.points @ planes.normals.T)[:, planes.direction] / distance[:, None]
    return np.asarray(distance[:, None] ** 2 / np.maximum(cosine, 0.1))


def _overlap(along: Vector, sets: list[Mask]) -> tuple[float, float]:
    """Return the range of positions that all sets of points span, by their first and last points."""
    low, high = np.array([raw_ends(along[own]) for own in sets]).T
    return float(low.max()), float(high.min())


def _edge(along: Vector, sets: list[Mask], area: Array, settings: Settings) -> tuple[float, float]:
    """Return the range of positions of a box's edge, on which both faces end where it does.

    A face that ends earlier has lost points, to grazing incidence or behind something: the outer end counts, and where the two
    agree their mean, each weighted by its points.
    """
    low, high = np.array([half_density_ends(along[own], area[own, k]) for k, own in enumerate(sets)]).T
    points = np.array([np.count_nonzero(own) for own in sets])
    begins, ends = low < low.min() + settings.merge_band, high > high.max() - settings.merge_band
    return float(np.average(low[begins], weights=points[begins])), float(np.average(high[ends], weights=points[ends]))

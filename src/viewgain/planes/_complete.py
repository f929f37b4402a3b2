"""Faces that the pairs did not vote for (a mend of ours): two orthogonal directions fix the third, and points fix offsets.

A face that shows as a strip of pixels has few points whose normals are its own, so its pairs win no cell. Yet its direction is
known once two others are, and its points still lie at one offset along it.
"""

import numpy as np

from viewgain.arrays import Array, Points, Rotation
from viewgain.geometry import nearest_rotation
from viewgain.planes._cloud import Cloud
from viewgain.planes._normals import cloud_normals
from viewgain.planes._parallel import Planes
from viewgain.planes._refine import assigned
from viewgain.planes._settings import Settings

_CELL = 0.01
"""Width of the cells in which offsets are counted, metres."""
_FREE_POINTS = 3000
"""Of more points than this near no plane a part is looked at."""
_MOST = 4
"""At most so many faces are added: with the floor and two others a box shows no more."""


def completed(planes: Planes, cloud: Cloud, settings: Settings) -> Planes:
    """Return the planes with those added, along the box's three directions, that many points near no plane agree on.

    Points count along the direction that their normal is closest to; it is estimated anew from points near no plane alone, for
    across an edge the other face turns it. The highest count is added first; it ends when a count is
    under ``min_inliers``. Without two orthogonal directions nothing is added.
    """
    axes = box_axes(planes, cloud, settings)
    if axes is None:
        return planes
    planes = _along(planes, axes, settings)
    for _ in range(_MOST):
        peaks = [_peak(along, settings) for along in _free_positions(planes, axes, cloud, settings)]
        best = int(np.argmax([count for count, _ in peaks]))
        count, at = peaks[best]
        if count < settings.min_inliers:
            break
        planes = Planes(axes, np.append(planes.direction, best), np.append(planes.offsets, -at), planes.edges)
    return planes


def box_axes(planes: Planes, cloud: Cloud, settings: Settings) -> Rotation | None:
    """Return the right-handed (3, 3) rows of the direction with the most points, the best one orthogonal to it, and the third.

    None where no direction is orthogonal to the one with the most points.
    """
    plane, _ = assigned(planes, cloud, settings)
    support = np.bincount(planes.direction[plane[plane >= 0]], minlength=len(planes.normals))
    if len(support) < 2:
        return None
    first = int(np.argmax(support))
    right = np.abs(planes.normals @ planes.normals[first]) < settings.right
    if not right.any():
        return None
    second = int(np.argmax(np.where(right, support, -1)))
    one, other = planes.normals[[first, second]]
    return nearest_rotation(np.stack([one, other, np.cross(one, other)]))


def _along(planes: Planes, axes: Rotation, settings: Settings) -> Planes:
    """Return the planes along the axes, which become the directions, all at right angles."""
    cosine = planes.normals @ axes.T
    axis = np.argmax(np.abs(cosine), axis=1)
    sign = np.sign(cosine[np.arange(len(axis)), axis])
    kept = (np.abs(cosine).max(axis=1) > settings.parallel)[planes.direction]
    direction = planes.direction[kept]
    return Planes(axes, axis[direction], sign[direction] * planes.offsets[kept], np.array([[0, 1], [0, 2], [1, 2]]))


def _free_positions(planes: Planes, axes: Rotation, cloud: Cloud, settings: Settings) -> list[Array]:
    """Return, per axis, where along it the points lie that are near no plane and whose normals are closest to it.

    Points within two bands of a parallel plane are its own noise rather than another face.
    """
    free = cloud.points[np.abs(planes.heights(cloud.points)).min(axis=1) >= settings.band]
    free = free[:: 1 + len(free) // _FREE_POINTS]
    closest = np.argmax(np.abs(cloud_normals(free, settings.normal_radius) @ axes.T), axis=1)
    away = [
        np.abs(planes.heights(free)[:, planes.direction == k]).min(axis=1, initial=np.inf) >= 2 * settings.band for k in range(3)
    ]
    return [free[(closest == k) & away[k]] @ axes[k] for k in range(3)]


def _peak(along: Array, settings: Settings) -> tuple[int, float]:
    """Return how many positions lie within half the band of where most do, and their mean; (0, 0) for none."""
    if len(along) == 0:
        return 0, 0.0
    cell = ((along - along.min()) / _CELL).astype(int)
    width = max(1, round(settings.band / _CELL))
    count = np.convolve(np.bincount(cell), np.ones(width))
    middle = along.min() + (int(np.argmax(count)) - width / 2 + 1) * _CELL
    near: Points = along[np.abs(along - middle) < settings.band / 2]
    return len(near), float(near.mean()) if len(near) else 0.0

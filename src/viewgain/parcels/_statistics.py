"""The measured quantities as numbers of a set of points, and what in a scan says how far they can be from the truth.

Of the object the scan shows the front. Every quantity is taken twice: of the seen points, which the object surely fills, and of
these with their shadow: a ray that ended on the object says nothing about what lies behind, down to the floor, and rays beside it
that came to the floor say that nothing stands there. So the object lies inside the hull of seen points and shadow (ours).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from viewgain.arrays import Array, Points, Vector
from viewgain.parcels._objects import SeenObject
from viewgain.parcels._smallest import Cuboid, smallest_box, upright_box
from viewgain.parcels._volumes import heap_volume, hull_volume

QUANTITIES = (
    "upright_length",
    "upright_width",
    "upright_height",
    "upright_volume",
    "free_length",
    "free_width",
    "free_height",
    "free_volume",
    "hull_volume",
    "heap_volume",
)
"""Names of the quantities: of the standing box, of the box in any orientation, and the two volumes."""
POWERS = {"upright_volume": 3, "free_volume": 3, "hull_volume": 3, "heap_volume": 3}
"""Powers of a length that a quantity is; 1 where it is not here."""
FEATURES = ("one", "shadow", "short", "low", "steep", "coarse", "noisy", "thin")
"""Names of what the calibration looks at (:func:`features`)."""
_CELLS_PER_PITCH = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Statistics:
    """The quantities of one set of points, and the boxes that they come from."""

    upright: Cuboid
    """The standing box, floor frame."""
    free: Cuboid
    """The box in any orientation, floor frame."""
    values: Vector
    """(10,) in the order of :data:`QUANTITIES`, metres and cubic metres."""


def statistics(points: Points, cell: float, *, heap: float | None = None) -> Statistics:
    """Return the quantities of (n, 3) points in a frame whose floor is z = 0.

    Args:
        points: The points.
        cell: Side of the cells of the heap's grid, metres.
        heap: The heap volume where it is known already, cubic metres.
    """
    corners = _corners(points)
    upright, free = upright_box(corners), smallest_box(corners)
    volumes = hull_volume(corners), heap_volume(points, cell) if heap is None else heap
    return Statistics(
        upright, free, np.array([*upright.extents, upright.volume, *free.extents, free.volume, *volumes], dtype=float)
    )


def seen_and_possible(seen: SeenObject) -> tuple[Statistics, Statistics]:
    """Return the quantities of the seen points, and of all that the object can fill: seen points and their shadow."""
    cell = _CELLS_PER_PITCH * seen.pitch
    both = np.concatenate([seen.points, seen.shadow])
    near = statistics(seen.points, cell)
    return near, statistics(both, cell, heap=heap_volume(_along_shadow(seen), cell))


def features(seen: SeenObject, near: Statistics, far: Statistics) -> Array:
    """Return the (10, 8) features of each quantity, in the order of :data:`FEATURES`; none knows what kind of object it is.

    - one: 1.
    - shadow: log of the quantity with the shadow over that of the seen points: how much could be hidden.
    - short: log of the seen points' extent across the view over that along it, laid on the floor: a front alone is short.
    - low: log of their extent across the view over their height.
    - steep: sine of the angle at which the camera looks down on the object.
    - coarse: pixel size over the object's size; the outline is known to about a pixel.
    - noisy: noise of a return over the object's size.
    - thin: log of the cube root of the seen box's volume over that of the seen hull's: how empty the box is.
    """
    values, bounds = near.values, far.values
    length = np.maximum(np.array([v ** (1 / POWERS.get(name, 1)) for v, name in zip(values, QUANTITIES, strict=True)]), 1e-3)
    shadow = np.clip(np.log(np.maximum(bounds, 1e-12) / np.maximum(values, 1e-12)), 0.0, 4.0)
    across, along, height, steep = _view_extents(seen)
    size = float(np.exp(np.mean(np.log(np.maximum(near.free.extents, 1e-3)))))
    thin = np.log(max(near.free.volume, 1e-9) / max(near.values[8], 1e-9)) / 3
    shared = [1.0, float(np.clip(np.log(across / along), -1.5, 1.5)), float(np.clip(np.log(across / height), -2, 2)), steep]
    columns = np.tile(np.array([*shared, seen.pitch, seen.sigma, float(np.clip(thin, 0, 1.5))]), (len(values), 1))
    columns[:, 4:6] = np.minimum(columns[:, 4:6] / np.maximum(length, 0.1 * size)[:, None], 1.0)
    return np.insert(columns, 1, shadow, axis=1)


def _view_extents(seen: SeenObject) -> tuple[float, float, float, float]:
    """Return the extents across and along the view on the floor, the height, and the sine of the camera's depression."""
    camera = -seen.floor_frame[:3, :3].T @ seen.floor_frame[:3, 3]
    line = seen.points.mean(axis=0) - camera
    along = line[:2] / max(float(np.linalg.norm(line[:2])), 1e-9)
    forward, sideways = seen.points[:, :2] @ along, seen.points[:, :2] @ np.array([-along[1], along[0]])
    extents = [max(float(np.ptp(part)), 0.01) for part in (sideways, forward, np.append(seen.points[:, 2], 0.0))]
    return extents[0], extents[1], extents[2], float(-line[2] / np.linalg.norm(line))


def _along_shadow(seen: SeenObject, steps: int = 12) -> Points:
    """Return points along each ray from the object down to the floor."""
    share = np.linspace(0, 1, steps)[:, None, None]
    return np.asarray((seen.points + share * (seen.shadow - seen.points)).reshape(-1, 3))


def _corners(points: Points) -> Points:
    """Return the corners of the convex hull of the points, or all of them where they have no volume."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        return points

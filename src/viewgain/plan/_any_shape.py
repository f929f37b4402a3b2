"""Policies that ask for no box: voxels around what the scans show, and what is seen taken to reach down to the floor."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Mask, Points, Pose, Vector
from viewgain.camera import Intrinsics, Sensor
from viewgain.gain import GridKnown, Objective
from viewgain.geometry import inverse, transform
from viewgain.plan._views import Seen
from viewgain.plan._volumetric import Mapper, VolumetricPolicy
from viewgain.voxels import CERTAIN, Lattice

_VOXELS = 40
_POINTS = 700
"""More points are thinned to about so many before they are made into columns: what hides what is asked of coarse cells."""
_LAYERS = 4
"""Points of a column, from the floor up."""
_CELL, _BEHIND = 0.04, 0.05
"""A point is hidden if another in the same cell, so wide at the object, lies nearer by so much, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class WatchedPolicy:
    """A volumetric metric on voxels around what stands on the floor: twice as long and wide as what is seen, and as high.

    The floor is left out: its underside is no surface to look for.
    """

    metric: Objective[GridKnown]
    """One of :data:`viewgain.gain.VOLUMETRIC`."""
    sensor: Sensor
    """The camera."""

    @property
    def name(self) -> str:
        """The metric's."""
        return self.metric.name

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) gains by the metric; NaN where nothing stands on a floor."""
        points = seen_points(seen, self.sensor)
        if not len(points):
            return np.full(len(seen.candidates), np.nan)
        above = points[points[:, 2] > 0]
        low, high = above.min(axis=0), above.max(axis=0)
        half = max((high - low)[:2].max(), _CELL)
        middle = (low + high)[:2] / 2
        corners = np.array([[*(middle - half), low[2]], [*(middle + half), high[2]]])
        lattice = Lattice.around(corners, voxels=_VOXELS, margin=0)
        return VolumetricPolicy(self.metric, Mapper(lattice, model=CERTAIN)).scores(seen)


@dataclass(frozen=True, slots=True, eq=False)
class ColumnsPolicy:
    """Takes all that is seen to reach down to the floor, and goes where the hull of what is seen would then be largest (ours).

    A hull of what was seen is too small, so the view that makes it largest is the one that errs least. That what stands on a
    floor fills the columns under its upper surface is a guess about the hidden side that knows no kind of object.
    """

    sensor: Sensor
    """The camera."""
    name: str = "columns"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) hull volumes, cubic metres, of what was seen and what a candidate sees of the columns; NaN without any."""
        from viewgain.parcels import hull_volume  # plain measuring loads the planner's words, and need not load this

        points = seen_points(seen, self.sensor)
        if not len(points):
            return np.full(len(seen.candidates), np.nan)
        points = points[:: -(-len(points) // _POINTS)]
        columns = columns_under(points)
        return np.array([
            hull_volume(np.concatenate([points, columns[unhidden(columns, pose, seen.camera)]])) for pose in seen.candidates
        ])  # fmt: skip


def seen_points(seen: Seen, sensor: Sensor) -> Points:
    """Return (n, 3) points of all scans of what stands on the floor z = 0, world frame, metres; (0, 3) without any."""
    from viewgain.parcels import standing, standing_points  # as above

    parts = [standing(scan, camera=sensor) for scan in seen.scans]
    return standing_points([part for part in parts if part is not None])


def columns_under(points: Points) -> Points:
    """Return (4n, 3) points: (n, 3) points over the floor z = 0, at their own height, at 2/3 and 1/3 of it and on the floor."""
    return np.concatenate([points * (1.0, 1.0, share) for share in np.linspace(0, 1, _LAYERS)])


def unhidden(points: Points, camera_to_world: Pose, camera: Intrinsics) -> Mask:
    """Return (n,) which of (n, 3) points fall into the image and have no other well before them in their cell."""
    local = transform(inverse(camera_to_world), points)
    away = np.linalg.norm(local, axis=1)
    seen = np.flatnonzero(local[:, 2] > 0)
    pixels = camera.project(local[seen])
    seen = seen[np.all((pixels > -0.5) & (pixels < np.array([camera.width, camera.height]) - 0.5), axis=1)]
    mask = np.zeros(len(points), dtype=bool)
    if not len(seen):
        return mask
    cells = np.floor(local[seen, :2] / local[seen, 2:] * (np.median(away[seen]) / _CELL)).astype(int)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    nearest = np.full(cell.max() + 1, np.inf)
    np.minimum.at(nearest, cell.ravel(), away[seen])
    mask[seen] = away[seen] <= nearest[cell.ravel()] + _BEHIND
    return mask

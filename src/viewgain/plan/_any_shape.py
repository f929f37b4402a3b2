"""Policies that ask for no box: voxels around what the scans show, and the seen side turned round as a guess of the other."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from viewgain.arrays import Mask, Points, Vector, Vector3
from viewgain.camera import Sensor
from viewgain.gain import GridKnown, Objective
from viewgain.parcels import hull_volume, smallest_rectangle, standing, standing_points
from viewgain.plan._views import Seen
from viewgain.plan._volumetric import Mapper, VolumetricPolicy
from viewgain.voxels import CERTAIN, Lattice

_VOXELS = 40
_FLIP_RADIUS = 2.0
"""log10 of the radius of the flipping sphere over the farthest point's distance."""


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
        low, high = points.min(axis=0), points.max(axis=0)
        half = (high - low)[:2].max()
        middle = (low + high)[:2] / 2
        corners = np.array([[*(middle - half), low[2]], [*(middle + half), high[2]]])
        lattice = Lattice.around(corners, voxels=_VOXELS, margin=0)
        return VolumetricPolicy(self.metric, Mapper(lattice, model=CERTAIN)).scores(seen)


@dataclass(frozen=True, slots=True, eq=False)
class CompletedPolicy:
    """Guesses the unseen side, and goes where the hull of all that is seen would be largest (ours).

    Most things look alike from two opposite sides: the seen points, turned by half a turn about the upright axis of their
    standing box, stand in for what is not seen. What a candidate sees of them is told by flipping (Katz, Tal and Basri 2007).
    """

    sensor: Sensor
    """The camera."""
    name: str = "completed"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) hull volumes, cubic metres; NaN where nothing stands on a floor."""
        points = seen_points(seen, self.sensor)
        if not len(points):
            return np.full(len(seen.candidates), np.nan)
        whole = np.concatenate([points, turned_round(points)])
        return np.array([
            hull_volume(np.concatenate([points, whole[visible(whole, pose[:3, 3])]])) for pose in seen.candidates
        ])  # fmt: skip


def seen_points(seen: Seen, sensor: Sensor) -> Points:
    """Return (n, 3) points of all scans of what stands on the floor z = 0, world frame."""
    parts = [standing(scan, camera=sensor) for scan in seen.scans]
    return standing_points([part for part in parts if part is not None])


def turned_round(points: Points) -> Points:
    """Return (n, 3) points after half a turn about the upright axis of the smallest standing box around them."""
    yaw, low, high = smallest_rectangle(points[:, :2])
    x, y = (low + high) / 2
    cosine, sine = np.cos(yaw), np.sin(yaw)
    middle = np.array([cosine * x - sine * y, sine * x + cosine * y])
    return np.column_stack([2 * middle - points[:, :2], points[:, 2]])


def visible(points: Points, eye: Vector3) -> Mask:
    """Return (n,) which of (n, 3) points are seen from ``eye``, though they have no surface; all where they are flat.

    Source:
        Katz, Tal and Basri (2007), "Direct visibility of point sets".
    """
    sight = points - eye
    away = np.linalg.norm(sight, axis=1, keepdims=True)
    flipped = sight * (2 * 10**_FLIP_RADIUS * away.max() / away - 1)
    try:
        corners = ConvexHull(np.concatenate([flipped, np.zeros((1, 3))])).vertices
    except (QhullError, ValueError):
        return np.ones(len(points), dtype=bool)
    found = np.zeros(len(points) + 1, dtype=bool)
    found[corners] = True
    return found[:-1]

"""A viewer infinitely far away: world points to the plane of the picture, z up, all axes at one scale."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Points, Points2, Vector, Vector3

ELEVATION = np.deg2rad(32.0)
"""Height of the viewer above the horizon: the ring of cameras opens up and boxes still look tall."""


@dataclass(frozen=True, slots=True, eq=False)
class Viewpoint:
    """Where the viewer stands."""

    right: Vector3
    """(3,) world direction that is right in the picture."""
    up: Vector3
    """(3,) world direction that is up in the picture."""
    towards: Vector3
    """(3,) world direction to the viewer."""

    @classmethod
    def at(cls, azimuth: float, elevation: float = ELEVATION) -> "Viewpoint":
        """Return the viewer in a direction (radians, world frame)."""
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        towards = np.cos(elevation) * level + np.array([0.0, 0.0, np.sin(elevation)])
        return cls(right, np.cross(towards, right), towards)

    def picture(self, points: Points) -> Points2:
        """Return the (..., 2) place in the picture of (..., 3) world points, metres."""
        return np.asarray(points @ np.column_stack([self.right, self.up]))

    def nearness(self, points: Points) -> Vector:
        """Return how far (..., 3) world points stand towards the viewer, metres."""
        return np.asarray(points @ self.towards)


def clearest(centre: Vector3, cameras: Points, preferred: float) -> Viewpoint:
    """Return the viewpoint from which box and cameras stand farthest apart in the picture.

    Args:
        centre: (3,) centre of the box, world frame.
        cameras: (k, 3) camera places, world frame.
        preferred: Azimuth that is taken where others are no better, radians.
    """
    azimuths = preferred + np.deg2rad([0, 10, -10, 20, -20, 30, -30, 40, -40])
    # Along a world axis the floor would show as a rectangle, with the marks of one axis beside the picture.
    azimuths = azimuths[np.abs(np.mod(azimuths, np.pi / 2) - np.pi / 4) < np.deg2rad(27)]
    places: Array = np.vstack([centre, cameras])
    return max((Viewpoint.at(float(azimuth)) for azimuth in azimuths), key=lambda view: _least_gap(view.picture(places)))


def _least_gap(places: Points2) -> float:
    """Return the least distance between two of (k, 2) places that do not coincide, in whole hundredths of their spread."""
    gaps = np.linalg.norm(places[:, None] - places[None], axis=-1)
    spread = max(float(gaps.max()), 1e-9)
    return float(np.round(100 * np.min(gaps / spread, initial=1.0, where=gaps > 0.02 * spread)))

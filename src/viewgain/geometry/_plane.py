"""Planes as (normal, offset) with normal . x + offset = 0 and |normal| = 1."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Points, Pose, Vector3
from viewgain.geometry._rigid import pose


@dataclass(frozen=True, slots=True)
class Plane:
    """An oriented plane: ``normal . x + offset`` is the signed height of x above it, metres."""

    normal: Vector3
    offset: float

    def height(self, points: Points) -> Array:
        """Return the signed height of (..., 3) ``points``, metres; positive on the side the normal points to."""
        return np.asarray(points @ self.normal + self.offset)

    def flipped(self) -> "Plane":
        """Return the same plane with the other orientation."""
        return Plane(-self.normal, -self.offset)


def fit_plane(points: Points) -> Plane:
    """Return the least-squares plane of (n, 3) ``points`` (n >= 3), oriented so that the origin has positive height."""
    centre = points.mean(axis=0)
    _, vectors = np.linalg.eigh(np.cov((points - centre).T))
    plane = Plane(vectors[:, 0], -float(vectors[:, 0] @ centre))
    return plane if plane.offset >= 0 else plane.flipped()


def floor_to_camera(floor: Plane) -> Pose:
    """Return the pose of the floor's frame in the camera: z along the floor's normal, origin on the floor below the camera.

    The floor's y axis is the camera's line of sight laid on the floor (its image-up direction for a camera straight overhead),
    so x points to the right as the camera sees it.
    """
    z = floor.normal
    forward = np.array([0.0, 0.0, 1.0]) - z[2] * z
    if np.linalg.norm(forward) < 1e-3:
        forward = np.array([0.0, -1.0, 0.0]) + z[1] * z
    y = forward / np.linalg.norm(forward)
    return pose(np.column_stack([np.cross(y, z), y, z]), -floor.offset * z)

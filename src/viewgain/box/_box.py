"""The standing box: a pose whose z axis is the floor's normal, and three extents.

The box's own frame has its origin at the centre of the bottom face, z up through the top face, x and y along the sides, so the
floor is the plane z = 0 of the box's frame and one rigid motion places box and floor together.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Points, Pose, Vector3
from viewgain.geometry import Plane, cross_matrix, pose, rotation_from_rotvec

TOP = 4
"""Index of the top among the faces."""
FLOOR = 5
"""Index of the floor among the planes of :data:`PLANE_NORMALS`."""
FACES = ("+x", "-x", "+y", "-y", "top")
"""Names of the five faces that a camera above the floor can see, in index order."""
PLANE_NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 1]], dtype=float)
"""(6, 3) outward normals of the five faces and the floor, box frame."""
PLANE_EXTENTS = np.array([[0.5, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [0, 0.5, 0], [0, 0, 1], [0, 0, 0]], dtype=float)
"""(6, 3): plane k is normal . x = PLANE_EXTENTS[k] . extents."""
CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (-0.5, 0.5) for x in (-0.5, 0.5)], dtype=float)
"""(8, 3) corners of the unit box: a corner is CORNERS[k] * extents."""
PARAMETERS = 9
"""Rotation (3) and translation (3) of the box's frame, then the three extents: the tangent space of a standing box."""


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """A box on a floor, seen from a camera (or placed in any other frame).

    Or a stack of n boxes, (n, 4, 4) and (n, 3), each in its own camera's frame: functions that take one say so, and what they
    return then has n as its first dimension.
    """

    box_to_camera: Pose
    """(4, 4) pose of the box's frame: origin at the centre of the bottom face, z up."""
    extents: Vector3
    """(3,) side lengths along the box's x, y and z, metres, positive."""

    @classmethod
    def stack(cls, boxes: "Sequence[Box]") -> "Box":
        """Return a stack of boxes, one or more."""
        return cls(np.array([box.box_to_camera for box in boxes]), np.array([box.extents for box in boxes], dtype=float))

    @property
    def volume(self) -> float:
        """Volume, cubic metres."""
        return float(np.prod(self.extents))

    @property
    def floor(self) -> Plane:
        """The floor that the box stands on, camera frame, with the camera on its positive side."""
        normal = self.box_to_camera[:3, 2]
        return Plane(normal, -float(normal @ self.box_to_camera[:3, 3]))

    @property
    def centre(self) -> Vector3:
        """(3,) centre of the box, camera frame; of a stack too."""
        return np.asarray(self.box_to_camera[..., :3, 3] + self.box_to_camera[..., :3, 2] * self.extents[..., 2:] / 2)

    def corners(self) -> Points:
        """Return the (8, 3) corners, camera frame, in the order of :data:`CORNERS`; of a stack too."""
        return self.in_camera(CORNERS * self.extents[..., None, :])

    def in_camera(self, points: Points) -> Points:
        """Return (m, 3) points of the box's frame in the camera's; of a stack too."""
        return np.asarray(points @ self.box_to_camera[..., :3, :3].mT + self.box_to_camera[..., None, :3, 3])

    def take(self, chosen: Indices) -> "Box":
        """Return some of a stack."""
        return Box(self.box_to_camera[chosen], self.extents[chosen])

    def moved(self, step: Array) -> "Box":
        """Return the box after a step in its tangent space.

        Args:
            step: (9,) rotation vector and translation in the box's own frame (radians, metres), then change of extents (metres).
        """
        motion = pose(rotation_from_rotvec(step[:3]), step[3:6])
        return Box(self.box_to_camera @ motion, self.extents + step[6:])

    def in_frame(self, camera_to_other: Pose) -> "Box":
        """Return the same box in another frame; of a stack too."""
        return Box(camera_to_other @ self.box_to_camera, self.extents)


def adjoint(a_to_b: Pose) -> Array:
    """Return the (6, 6) matrix that takes a small motion (rotation, translation) expressed in frame a to frame b.

    Of a stack (..., 4, 4) a stack.
    """
    rotation, translation = a_to_b[..., :3, :3], a_to_b[..., :3, 3]
    matrix = np.zeros((*a_to_b.shape[:-2], 6, 6))
    matrix[..., :3, :3] = matrix[..., 3:, 3:] = rotation
    matrix[..., 3:, :3] = cross_matrix(translation) @ rotation
    return matrix

"""What stands in the world: boxes, meshes, and the planes of floor and walls. The world's floor is z = 0, z up."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Pose
from viewgain.box import Box
from viewgain.errors import ConfigError
from viewgain.geometry import Plane
from viewgain.meshes import TriangleMesh

UP = np.array([0.0, 0.0, 1.0])
"""The world's up direction."""
FLOOR = Plane(UP, 0.0)
"""The world's floor."""
GREY = 0.5
"""Reflectivity of what is not said otherwise: halfway; cardboard and concrete in the near infrared lie around it (assumed)."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Bodies in the world, and how much light each gives back."""

    boxes: tuple[Box, ...] = ()
    """Boxes in any pose (``box_to_camera`` maps to the world here: the camera is the world's origin)."""
    meshes: tuple[TriangleMesh, ...] = ()
    """Meshes in world coordinates, metres."""
    planes: tuple[Plane, ...] = (FLOOR,)
    """Floor and walls: infinite planes, seen from the side their normals point to."""
    reflectivity: tuple[float, ...] = ()
    """Share of light each body gives back, (0, 1], in the order boxes, meshes, planes; empty for :data:`GREY` everywhere."""

    def __post_init__(self) -> None:
        count = len(self.boxes) + len(self.meshes) + len(self.planes)
        if self.reflectivity and len(self.reflectivity) != count:
            raise ConfigError(f"scene: got {len(self.reflectivity)} reflectivities for {count} bodies, wanted one each, or none")
        if not all(0 < value <= 1 for value in self.reflectivity):
            raise ConfigError(f"scene: got reflectivities {self.reflectivity}, wanted numbers over 0 and up to 1")

    @property
    def body_reflectivity(self) -> Array:
        """(bodies,) reflectivity of each body, in the order boxes, meshes, planes."""
        count = len(self.boxes) + len(self.meshes) + len(self.planes)
        return np.array(self.reflectivity) if self.reflectivity else np.full(count, GREY)

    def moved(self, motion: Pose) -> "Scene":
        """Return the whole scene after a (4, 4) rigid motion of the world."""
        return Scene(
            tuple(box.in_frame(motion) for box in self.boxes),
            tuple(mesh.moved(motion) for mesh in self.meshes),
            tuple(_moved_plane(plane, motion) for plane in self.planes),
            self.reflectivity,
        )


def wall(azimuth: float, distance: float) -> Plane:
    """Return an upright plane that faces the world's origin from a direction (radians) and distance (metres)."""
    return Plane(-np.array([np.cos(azimuth), np.sin(azimuth), 0.0]), distance)


def _moved_plane(plane: Plane, motion: Pose) -> Plane:
    normal = motion[:3, :3] @ plane.normal
    return Plane(normal, plane.offset - float(normal @ motion[:3, 3]))

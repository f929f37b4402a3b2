"""What a rig stands around: a frame on the floor and the extents of what stands there."""

from dataclasses import dataclass, field

import numpy as np

from viewgain.arrays import Pose, Vector3
from viewgain.errors import ConfigError
from viewgain.geometry import pose, require_rigid, rotation_from_rotvec, transform


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """The bounding box of the object to look at, in the frame of a box (docs/conventions.md). Without extents it is a point."""

    target_to_world: Pose
    """(4, 4) origin at the centre of the bottom face, z up, x and y along the sides."""
    extents: Vector3 = field(default_factory=lambda: np.zeros(3))
    """(3,) side lengths along x, y and z, metres; zeros where they are not known."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "target_to_world", require_rigid(self.target_to_world, "target_to_world"))
        object.__setattr__(self, "extents", np.asarray(self.extents, dtype=float))
        if self.extents.shape != (3,) or not np.all(np.isfinite(self.extents)) or np.any(self.extents < 0):
            raise ConfigError(f"target: got extents {self.extents.tolist()}, wanted three finite lengths, none negative")

    @classmethod
    def at(cls, centre: Vector3, extents: Vector3 | None = None, *, yaw: float = 0.0) -> "Target":
        """Return the upright target around a point.

        Args:
            centre: (3,) its centre, metres, world (z up).
            extents: (3,) its side lengths, metres; left out, it is a point.
            yaw: Its turn about the vertical, radians.
        """
        sides = np.zeros(3) if extents is None else np.asarray(extents, dtype=float)
        foot = np.asarray(centre, dtype=float) - np.array([0.0, 0.0, sides[2] / 2])
        return cls(pose(rotation_from_rotvec(np.array([0.0, 0.0, yaw])), foot), sides)

    @property
    def centre(self) -> Vector3:
        """(3,) its centre, metres, world."""
        return transform(self.target_to_world, np.array([0.0, 0.0, self.extents[2] / 2]))

    @property
    def yaw(self) -> float:
        """Turn of its x axis about the world's vertical, radians."""
        return float(np.arctan2(self.target_to_world[1, 0], self.target_to_world[0, 0]))

    def shifted(self, by: Vector3) -> "Target":
        """Return the same target moved by (3,) metres, world."""
        return Target(pose(self.target_to_world[:3, :3], self.target_to_world[:3, 3] + by), self.extents)

    def top_corner(self, quarter: int) -> Vector3:
        """Return the (3,) top corner over a quadrant of its frame, 0 to 3 anticlockwise from (+x, +y), metres, world."""
        sign = (1, -1, -1, 1)[quarter % 4], (1, 1, -1, -1)[quarter % 4]
        return transform(self.target_to_world, np.array([sign[0] / 2, sign[1] / 2, 1.0]) * self.extents)

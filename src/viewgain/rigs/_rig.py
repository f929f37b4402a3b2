"""The records: a station, the cone that a camera must not enter, and the rig that holds them in order."""

import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Pose, Vector3
from viewgain.errors import ConfigError
from viewgain.geometry import require_rigid
from viewgain.rigs._jitter import NO_JITTER, Jitter


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """One candidate of a rig. It looks at the target's centre, or at one of its top corners; None leaves a value open."""

    azimuth: float = 0.0
    """Turn about the target's vertical, radians, anticlockwise from above (moves the camera to its right).

    It counts from the present camera, from the world's x axis, or for a corner from the footprint's diagonal.
    """
    elevation: float | None = None
    """Angle above the horizon as seen from what is looked at, radians."""
    distance: float | None = None
    """From what is looked at, metres."""
    corner: int | None = None
    """Look at this top corner, 0 to 3 anticlockwise; 0 faces the present camera, or is the (+x, +y) one of the target's frame."""
    unnormalised: bool = False
    """Divide the horizontal offset from the corner by the half diagonal of the footprint in metres: the authors' scripts do."""
    camera_to_world: Pose | None = None
    """A pose instead of all of the above."""
    name: str = ""
    """What its scans' folder is called where each station has one; empty for its number."""

    def __post_init__(self) -> None:
        # A folder's name on any system, and no hidden one: a reader of recordings passes over those.
        if not re.fullmatch(r"([A-Za-z0-9_][A-Za-z0-9_-]*)?", self.name):
            raise ConfigError(f"got a station called {self.name!r}, wanted letters, digits, _ and - only")
        numbers = (self.azimuth, self.elevation or 0.0, 1.0 if self.distance is None else self.distance)
        if not np.all(np.isfinite(numbers)) or numbers[2] <= 0:
            raise ConfigError(f"got angles {numbers[:2]} and distance {numbers[2]}, wanted finite ones and a positive distance")
        if self.corner not in (None, 0, 1, 2, 3) or (self.unnormalised and self.corner is None):
            raise ConfigError(f"got corner {self.corner}, wanted 0 to 3 (or none, and then not unnormalised)")
        if self.camera_to_world is not None:
            if self.azimuth or not self.elevation is self.distance is self.corner is None:
                raise ConfigError("got camera_to_world and angles, distance or corner; wanted the one or the others")
            object.__setattr__(self, "camera_to_world", require_rigid(self.camera_to_world, "camera_to_world"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KeepOut:
    """A cone in which no camera may stand: towards the robot's base, say, or a ceiling mount."""

    axis: Vector3
    """(3,) its direction away from the apex, world (z up); of any length."""
    half_angle: float
    """Angle between axis and mantle, radians, up to pi."""
    apex: Vector3 | None = None
    """(3,) metres, world; None is the target's centre."""

    def __post_init__(self) -> None:
        axis = np.asarray(self.axis, dtype=float)
        apex = np.zeros(3) if self.apex is None else np.asarray(self.apex, dtype=float)
        if axis.shape != (3,) or apex.shape != (3,) or not np.all(np.isfinite([axis, apex])) or not np.any(axis):
            raise ConfigError("got a keep-out cone without direction or place, wanted axis and apex as three finite numbers")
        if not 0 < self.half_angle <= np.pi:
            raise ConfigError(f"got a keep-out cone of half angle {self.half_angle}, wanted one between 0 and pi (180 degrees)")
        object.__setattr__(self, "axis", axis / np.linalg.norm(axis))
        object.__setattr__(self, "apex", None if self.apex is None else apex)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rig:
    """An ordered list of stations, how exactly they are reached, and the limits of whatever moves the camera."""

    name: str
    """Preset name, or the file it came from."""
    stations: tuple[Station, ...]
    """Candidates in rig order; scores are listed, and rolled, in this order."""
    jitter: Jitter = NO_JITTER
    """Errors of the cameras, drawn where a random generator is given."""
    absolute: bool = False
    """Whether azimuths count from the world's x axis also when the rig is anchored at a camera."""
    min_distance: float = 0.25
    """Nearest the camera may come to the target's surface, metres."""
    max_distance: float = np.inf
    """Farthest it may stand from the target's surface, metres."""
    min_height: float = 0.05
    """Lowest it may stand above the floor, metres."""
    max_height: float = np.inf
    """Highest it may stand above the floor, metres."""
    keep_out: tuple[KeepOut, ...] = ()
    """Cones in which it may not stand."""

    def __post_init__(self) -> None:
        least, most = (self.min_distance, self.min_height), (self.max_distance, self.max_height)
        if not self.stations or not np.isfinite(least).all() or not np.all(np.greater_equal(most, least)):
            raise ConfigError(
                f"rig {self.name}: wanted at least one station, finite min_distance and min_height, and maxima no less than those"
            )
        twice = [name for name, count in Counter(station.name for station in self.stations).items() if name and count > 1]
        if twice:
            raise ConfigError(f"rig {self.name}: got the name {twice[0]!r} for more than one station, wanted different ones")

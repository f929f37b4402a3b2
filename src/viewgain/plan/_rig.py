"""Rigs: ordered candidate camera poses around a target, anchored at the camera as it stands or given in the world."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viewgain.arrays import Pose, Poses, Vector3
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, look_at, require_rigid

LOWEST = float(np.deg2rad(10.0))
"""A station that keeps the present elevation is placed no lower than this: from under the target's middle a ring would run into
the floor, radians."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """One candidate of a rig, relative to the camera as it stands; None keeps the present value."""

    azimuth: float = 0.0
    """Turn about the target's vertical, radians; positive moves the camera to its right."""
    elevation: float | None = None
    """Angle above the horizon as seen from the target, radians."""
    distance: float | None = None
    """From the target, metres."""
    camera_to_world: Pose | None = None
    """An absolute pose instead of the three above."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rig:
    """An ordered list of stations and the limits of whatever moves the camera."""

    name: str
    """Preset name, or the file it came from."""
    stations: tuple[Station, ...]
    """Candidates in rig order; candidate 0 of the presets is the present direction."""
    min_distance: float = 0.25
    """Nearest the camera may come to the target's surface, metres."""
    min_height: float = 0.05
    """Lowest the camera may stand above the floor, metres."""

    def __post_init__(self) -> None:
        if not self.stations or not np.isfinite([self.min_distance, self.min_height]).all():
            raise ConfigError(f"rig {self.name}: wanted at least one station, and finite min_distance and min_height")


def _ring(count: int) -> tuple[Station, ...]:
    return tuple(Station(azimuth=2 * np.pi * k / count) for k in range(count))


def _paper() -> tuple[Station, ...]:
    """Return the paper's two distances times two heights, read off the authors' public scripts.

    The camera stands at horizontal offset d and height d tan(pi / 3.5) or d tan(pi / 2.9) from the top corner, d = 1 or 1.3 m;
    all four share one azimuth, here the present one.
    """
    elevations = (np.pi / 3.5, np.pi / 2.9)
    return tuple(Station(elevation=e, distance=d / float(np.cos(e))) for d in (1.0, 1.3) for e in elevations)


def _pcnbv() -> tuple[Station, ...]:
    """Return PC-NBV's 33 directions: the pole, then eight azimuths at elevations 60, 30, 0 and -30 degrees."""
    rows = [Station(elevation=np.pi / 2)]
    for elevation in np.deg2rad([60.0, 30.0, 0.0, -30.0]):
        rows += [Station(azimuth=np.pi * k / 4, elevation=float(elevation)) for k in range(8)]
    return tuple(rows)


RIGS = {
    "ring8": Rig(name="ring8", stations=_ring(8)),
    "paper4": Rig(name="paper4", stations=_paper()),
    "pcnbv33": Rig(name="pcnbv33", stations=_pcnbv()),
}
"""Rigs by name."""


def rig(name: str | Rig) -> Rig:
    """Return a preset rig by name, or the rig of a TOML file by its path (docs/rigs.md).

    Raises:
        ConfigError: If the name is no preset and no readable rig file.
    """
    if isinstance(name, Rig):
        return name
    if name in RIGS:
        return RIGS[name]
    path = Path(name)
    if path.suffix != ".toml":
        raise ConfigError(f"rig {name!r} is not known; choose one of {', '.join(RIGS)}, or give a .toml file")
    try:
        content = tomllib.loads(path.read_text())
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read as a rig file: {error}") from error
    return _from_table(content, path)


def place(rig: Rig, target: Vector3, floor_to_current: Pose, camera_to_world: Pose | None, *, step_back: float = 1.0) -> Poses:
    """Return the (v, 4, 4) poses ``camera_to_current`` of a rig's stations around ``target``.

    Args:
        rig: The rig.
        target: (3,) point that every anchored station looks at, metres, frame of the camera as it stands.
        floor_to_current: (4, 4) pose of the floor's frame (z up) in the present camera.
        camera_to_world: (4, 4) pose of the present camera; needed only for stations with an absolute pose.
        step_back: Factor on the present distance for stations without one of their own.

    Raises:
        ConfigError: If a station has an absolute pose and the scan has none.
    """
    up = floor_to_current[:3, 2]
    offset = -target
    height = float(offset @ up)
    flat = offset - height * up
    radius = float(np.linalg.norm(offset))
    present_elevation = max(float(np.arctan2(height, np.linalg.norm(flat))), LOWEST)
    ahead = flat / np.linalg.norm(flat) if np.linalg.norm(flat) > 0.02 * radius else -floor_to_current[:3, 1]
    right = np.cross(up, ahead)
    poses = np.empty((len(rig.stations), 4, 4))
    for index, station in enumerate(rig.stations):
        if station.camera_to_world is not None:
            if camera_to_world is None:
                raise ConfigError(f"rig {rig.name}: station {index} is given in the world, and the scan has no camera_to_world")
            poses[index] = inverse(camera_to_world) @ station.camera_to_world
            continue
        elevation = present_elevation if station.elevation is None else station.elevation
        distance = step_back * radius if station.distance is None else station.distance
        level = np.cos(station.azimuth) * ahead + np.sin(station.azimuth) * right
        direction = np.cos(elevation) * level + np.sin(elevation) * up
        # Straight overhead "up" is no guide; the image then keeps the direction that the ring had.
        guide = up if abs(np.cos(elevation)) > 1e-3 else -level
        poses[index] = look_at(target + distance * direction, target, guide)
    return poses


def _from_table(content: dict[str, object], path: Path) -> Rig:
    """Return the rig that a parsed TOML file describes."""
    unknown = set(content) - {"name", "min_distance", "min_height", "view"}
    views = content.get("view")
    if unknown or not isinstance(views, list) or not views:
        got = f"unknown keys {sorted(unknown)}" if unknown else "no [[view]] tables"
        raise ConfigError(f"{path}: got {got}; a rig file has name, min_distance, min_height and one [[view]] per station")
    try:
        return Rig(
            name=str(content.get("name", path.stem)),
            stations=tuple(_station(view, f"{path}: view {k}") for k, view in enumerate(views)),
            min_distance=float(content.get("min_distance", 0.25)),  # type: ignore[arg-type]
            min_height=float(content.get("min_height", 0.05)),  # type: ignore[arg-type]
        )
    except (TypeError, ValueError) as error:
        named = str(path) in str(error)
        raise error if named and isinstance(error, ConfigError) else ConfigError(f"{path}: {error}") from error


def _station(view: dict[str, object], where: str) -> Station:
    unknown = set(view) - {"azimuth_deg", "elevation_deg", "distance_m", "camera_to_world"}
    if unknown:
        raise ConfigError(
            f"{where}: unknown keys {sorted(unknown)}; wanted azimuth_deg, elevation_deg, distance_m or camera_to_world"
        )
    if "camera_to_world" in view:
        return Station(camera_to_world=require_rigid(np.asarray(view["camera_to_world"], dtype=float), where))
    numbers = {key: float(value) for key, value in view.items()}  # type: ignore[arg-type]
    if not np.all(np.isfinite(list(numbers.values()))) or numbers.get("distance_m", 1.0) <= 0:
        raise ConfigError(f"{where}: got {numbers}, wanted finite angles and a positive distance_m")
    elevation = numbers.get("elevation_deg")
    return Station(
        azimuth=float(np.deg2rad(numbers.get("azimuth_deg", 0.0))),
        elevation=None if elevation is None else float(np.deg2rad(elevation)),
        distance=numbers.get("distance_m"),
    )

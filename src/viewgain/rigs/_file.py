"""Rig files: TOML, in degrees and metres (docs/rigs.md). What is read is checked, never repaired."""

import json
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias, TypeVar

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ConfigError
from viewgain.rigs._jitter import NO_JITTER, Interval, Intervals, Jitter
from viewgain.rigs._rig import KeepOut, Rig, Station

T = TypeVar("T")
Table: TypeAlias = dict[str, object]
"""A TOML table."""
LIMITS = ("min_distance", "max_distance", "min_height", "max_height")
"""Limits of a rig, metres; named alike in the file."""
TOP_KEYS = ("name", "absolute", *LIMITS, "jitter", "keep_out", "view")
VIEW_KEYS = ("azimuth_deg", "elevation_deg", "distance_m", "corner", "unnormalised", "camera_to_world", "name")
JITTER_KEYS = ("azimuth_deg", "elevation_deg", "distance_share", "position_m", "aim_m", "rotation_deg")
KEEP_OUT_KEYS = ("axis", "half_angle_deg", "apex")


def read_rig(path: Path) -> Rig:
    """Return the rig that a TOML file describes.

    Raises:
        ConfigError: If the file cannot be read or describes no rig; one line that names file and place.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ConfigError(f"{path}: cannot be read as a rig file: {error}") from error
    with _inside(str(path)):
        _check_keys(content, TOP_KEYS)
        return Rig(
            name=str(content.get("name", path.stem)),
            stations=_each(content, "view", _station),
            jitter=_jitter(content["jitter"]) if "jitter" in content else NO_JITTER,
            absolute=_flag(content.get("absolute", False)),
            keep_out=_each(content, "keep_out", _keep_out) if "keep_out" in content else (),
            **{key: _number(content[key]) for key in LIMITS if key in content},
        )


def to_toml(rig: Rig) -> str:
    """Return the text of a rig file that describes ``rig``; read back, it is the same to rounding."""
    lines = [f"name = {json.dumps(rig.name, ensure_ascii=False)}", f"absolute = {_text(rig.absolute)}"]
    lines += [f"{key} = {_text(getattr(rig, key))}" for key in LIMITS]
    degrees = np.rad2deg(rig.jitter.bounds).tolist()
    metres = rig.jitter.bounds.tolist()
    jitter = (degrees[0], degrees[1], metres[2], metres[3:6], metres[6:9], degrees[9:12])
    lines += ["", "[jitter]", *(f"{key} = {_text(value)}" for key, value in zip(JITTER_KEYS, jitter, strict=True))]
    for cone in rig.keep_out:
        values = (cone.axis.tolist(), float(np.rad2deg(cone.half_angle)), None if cone.apex is None else cone.apex.tolist())
        lines += ["", "[[keep_out]]", *_lines(KEEP_OUT_KEYS, values)]
    for station in rig.stations:
        lines += ["", "[[view]]", *_lines(VIEW_KEYS, _values(station))]
    return "\n".join(lines) + "\n"


@contextmanager
def _inside(where: str) -> Iterator[None]:
    """Put ``where`` in front of whatever goes wrong inside."""
    try:
        yield
    except (TypeError, ValueError, OverflowError) as error:
        raise ConfigError(f"{where}: {error}") from error


def _each(content: Table, key: str, build: Callable[[object], T]) -> tuple[T, ...]:
    rows = content.get(key)
    if not isinstance(rows, list) or not rows:
        raise ConfigError(f"got no [[{key}]] tables, wanted one per {'station' if key == 'view' else 'cone'}")
    built = []
    for index, row in enumerate(rows):
        with _inside(f"{key} {index}"):
            built.append(build(row))
    return tuple(built)


def _check_keys(table: object, known: tuple[str, ...]) -> Table:
    if not isinstance(table, dict):
        raise ConfigError(f"got {table!r}, wanted a table with {', '.join(known)}")
    unknown = sorted(set(table) - set(known))
    if unknown:
        raise ConfigError(f"got unknown keys {unknown}, wanted {', '.join(known)}")
    return table


def _station(row: object) -> Station:
    view = _check_keys(row, VIEW_KEYS)
    corner = view.get("corner")
    if corner is not None and (isinstance(corner, bool) or not isinstance(corner, int)):
        raise ConfigError(f"got corner {corner!r}, wanted 0, 1, 2 or 3")
    return Station(
        azimuth=_radians(view.get("azimuth_deg", 0.0)),
        elevation=_radians(view["elevation_deg"]) if "elevation_deg" in view else None,
        distance=_number(view["distance_m"]) if "distance_m" in view else None,
        corner=corner,
        unnormalised=_flag(view.get("unnormalised", False)),
        camera_to_world=_array(view["camera_to_world"]) if "camera_to_world" in view else None,
        name=_word(view.get("name", "")),
    )


def _jitter(content: object) -> Jitter:
    with _inside("jitter"):
        table = _check_keys(content, JITTER_KEYS)
        azimuth, elevation, share = (_interval(table.get(key, 0.0)) for key in JITTER_KEYS[:3])
        position, aim, rotation = (_intervals(table.get(key, [0.0, 0.0, 0.0])) for key in JITTER_KEYS[3:])
        return Jitter(
            azimuth=_turn(azimuth),
            elevation=_turn(elevation),
            distance=share,
            position=position,
            aim=aim,
            rotation=(_turn(rotation[0]), _turn(rotation[1]), _turn(rotation[2])),
        )


def _keep_out(row: object) -> KeepOut:
    cone = _check_keys(row, KEEP_OUT_KEYS)
    missing = [key for key in KEEP_OUT_KEYS[:2] if key not in cone]
    if missing:
        raise ConfigError(f"got no {' and no '.join(missing)}, wanted both")
    apex = _array(cone["apex"]) if "apex" in cone else None
    return KeepOut(axis=_array(cone["axis"]), half_angle=_radians(cone["half_angle_deg"]), apex=apex)


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"got {value!r}, wanted a number")
    return float(value)


def _radians(value: object) -> float:
    return float(np.deg2rad(_number(value)))


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise ConfigError(f"got {value!r}, wanted true or false")
    return value


def _word(value: object) -> str:
    if not isinstance(value, str):
        raise ConfigError(f"got {value!r}, wanted a name in quotes")
    return value


def _array(value: object) -> Array:
    return np.asarray(value, dtype=float)


def _interval(value: object) -> Interval:
    """Return (low, high) from a list of the two, or from one number that goes either way."""
    if not isinstance(value, list):
        return -_number(value), _number(value)
    if len(value) != 2:
        raise ConfigError(f"got {value!r}, wanted one number or [low, high]")
    return _number(value[0]), _number(value[1])


def _intervals(value: object) -> Intervals:
    if not isinstance(value, list) or len(value) != 3:
        raise ConfigError(f"got {value!r}, wanted a list of three, for x, y and z")
    return _interval(value[0]), _interval(value[1]), _interval(value[2])


def _turn(interval: Interval) -> Interval:
    return float(np.deg2rad(interval[0])), float(np.deg2rad(interval[1]))


def _values(station: Station) -> tuple[object, ...]:
    """Return what a view's table holds, in the order of its keys; None is left out."""
    if station.camera_to_world is not None:
        return None, None, None, None, None, station.camera_to_world.tolist(), station.name or None
    elevation = None if station.elevation is None else float(np.rad2deg(station.elevation))
    azimuth, unnormalised = float(np.rad2deg(station.azimuth)), station.unnormalised or None
    return azimuth, elevation, station.distance, station.corner, unnormalised, None, station.name or None


def _lines(keys: tuple[str, ...], values: tuple[object, ...]) -> list[str]:
    return [f"{key} = {_text(value)}" for key, value in zip(keys, values, strict=True) if value is not None]


def _text(value: object) -> str:
    """Return booleans, numbers and nested lists of them as TOML (which is JSON for these, but for infinity)."""
    return json.dumps(value).replace("Infinity", "inf")

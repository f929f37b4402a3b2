"""The TOML format of a camera (docs/cameras.md): from a parsed table to a Sensor, or one line that names the file and the key."""

import tomllib
from typing import Any, TypeAlias

import numpy as np

from viewgain.camera._intrinsics import Intrinsics
from viewgain.camera._sensor import Sensor
from viewgain.errors import ConfigError

Table: TypeAlias = dict[str, Any]
"""A parsed TOML table."""

FIELDS = {
    "range": {"min": "range_min", "max": "range_max", "unambiguous": "unambiguous", "modulation_hz": "modulation_hz"},
    "noise": {
        "constant": "noise_constant",
        "per_metre": "noise_per_metre",
        "per_square_metre": "noise_per_square_metre",
        "incidence_power": "noise_incidence_power",
        "grazing": "noise_grazing",
        "grazing_range_power": "noise_grazing_range_power",
        "jitter_px": "jitter_px",
        "reflectivity": "noise_reflectivity",
    },
    "lateral": {"px": "lateral_px", "grazing_px": "lateral_grazing_px"},
    "signal": {
        "weakest": "weakest",
        "grazing_start_deg": "grazing_start",
        "grazing_end_deg": "grazing_end",
        "short_floor": "short_floor",
        "footprint_px": "footprint_px",
        "flying_filter": "flying_filter",
    },
    "systematic": {
        "scale": "scale",
        "offset": "offset",
        "scale_sd": "scale_sd",
        "offset_sd": "offset_sd",
        "wiggle": "wiggle",
        "wiggle_period": "wiggle_period",
    },
    "quantisation": {"step": "step", "per_square_metre": "step_per_square_metre"},
    "confidence": {"spread": "spread"},
    "edges": {"sd_px": "edge_sd_px", "lost_sd_px": "lost_edge_sd_px"},
}
"""Section and key of the file to the field of the record; a key that ends in _deg is in degrees, the field in radians."""
ANGLES = ("width", "height", "horizontal_deg", "vertical_deg")
FOCAL = ("width", "height", "fx", "fy", "cx", "cy")
"""The two ways to fill the section [image]; the second may add ``distortion``."""


def parse(text: str, where: str) -> Table:
    """Return the tables of a TOML text.

    Raises:
        ConfigError: If it is not TOML.
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also a number of too many digits
        raise ConfigError(f"{where}: cannot be read as a camera file: {error}") from error


def merged(base: Table, over: Table) -> Table:
    """Return ``over`` laid over ``base``, key by key in each section; [image] and single values are replaced as a whole."""
    result = dict(base)
    for key, value in over.items():
        below = result.get(key)
        both = isinstance(below, dict) and isinstance(value, dict) and key != "image"
        result[key] = {**below, **value} if both else value  # type: ignore[dict-item]
    return result


def sensor_from_table(content: Table, where: str, *, default_name: str) -> Sensor:
    """Return the camera that a parsed file describes.

    Args:
        content: The file's tables, with what it extends filled in.
        where: The file, for messages.
        default_name: Name of a camera whose file gives none.

    Raises:
        ConfigError: If a key is unknown, missing, of the wrong type or out of its range.
    """
    _known(content, ("name", "kind", "extends", "image", "sources", *FIELDS), where, "")
    words = {key: _word(content[key], key, where) for key in ("kind",) if key in content}
    name = _word(content.get("name", default_name), "name", where)
    numbers: dict[str, float] = {}
    for section, keys in FIELDS.items():
        table = _section(content, section, where)
        _known(table, keys, where, f"{section}.")
        for key, value in table.items():
            number = _number(value, f"{section}.{key}", where, endless=key == "unambiguous")
            numbers[keys[key]] = float(np.deg2rad(number)) if key.endswith("_deg") else number
    _check_sources(_section(content, "sources", where), where)
    intrinsics = _intrinsics(content, where)
    try:
        return Sensor(name=name, intrinsics=intrinsics, **words, **numbers)  # type: ignore[arg-type]
    except ConfigError as error:
        message = str(error)
        for section, keys in FIELDS.items():
            for key, field in keys.items():
                message = message.replace(f"got {field} =", f"got {section}.{key} =")
        raise ConfigError(f"{where}: {message}") from error


def _intrinsics(content: Table, where: str) -> Intrinsics:
    table = _section(content, "image", where)
    wanted = FOCAL if "fx" in table or "fy" in table else ANGLES
    _known(table, (*wanted, "distortion") if wanted is FOCAL else wanted, where, "image.")
    missing = [key for key in wanted if key not in table]
    if missing:
        raise ConfigError(
            f"{where}: lacks image.{missing[0]}; [image] has width, height and horizontal_deg, vertical_deg or fx, fy, cx, cy"
        )
    numbers = {key: _number(table[key], f"image.{key}", where) for key in wanted}
    for key in ("width", "height"):
        if not isinstance(table[key], int):
            raise ConfigError(f"{where}: got image.{key} = {table[key]}, wanted a whole number of pixels")
    width, height = table["width"], table["height"]
    try:
        if wanted is ANGLES:
            for key in ("horizontal_deg", "vertical_deg"):
                if not 0 < numbers[key] < 180:
                    raise ConfigError(f"got image.{key} = {numbers[key]:g}, wanted degrees between 0 and 180")
            horizontal, vertical = np.deg2rad([numbers["horizontal_deg"], numbers["vertical_deg"]])
            return Intrinsics.from_field_of_view(width, height, float(horizontal), float(vertical))
        focal = {key: numbers[key] for key in ("fx", "fy", "cx", "cy")}
        return Intrinsics(width=width, height=height, **focal, distortion=_distortion(table, where))
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from error


def _distortion(table: Table, where: str) -> tuple[float, ...]:
    listed = table.get("distortion", [])
    if not isinstance(listed, list):
        raise ConfigError(f"{where}: got image.distortion = {_short(listed)}, wanted a list of 0, 4, 5 or 8 numbers")
    return tuple(_number(value, f"image.distortion[{k}]", where) for k, value in enumerate(listed))


def _check_sources(sources: Table, where: str) -> None:
    for key, value in sources.items():
        section, _, rest = key.partition(".")
        image = section == "image" and rest in ("", *ANGLES, *FOCAL, "distortion")
        if not (image or (section in FIELDS and (not rest or rest in FIELDS[section]))):
            raise ConfigError(f'{where}: unknown key sources.{_short(key)}; wanted a section, or "section.key" in quotes')
        _word(value, f"sources.{key}", where)


def _section(content: Table, section: str, where: str) -> Table:
    table = content.get(section, {})
    if not isinstance(table, dict):
        raise ConfigError(f"{where}: got {section} = {_short(table)}, wanted a section [{section}]")
    return table


def _known(table: Table, keys: Any, where: str, prefix: str) -> None:
    unknown = [key for key in table if key not in keys]
    if unknown:
        raise ConfigError(f"{where}: unknown key {prefix}{_short(unknown[0])}; wanted {', '.join(keys)}")


def _number(value: object, key: str, where: str, *, endless: bool = False) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{where}: got {key} = {_short(value)}, wanted a number")
    try:
        number = float(value)
    except OverflowError as error:
        raise ConfigError(f"{where}: got a {key} of more than 300 digits, wanted a finite number") from error
    if not (np.isfinite(number) or (endless and number == np.inf)):
        raise ConfigError(f"{where}: got {key} = {number}, wanted a finite number")
    return number


def _word(value: object, key: str, where: str) -> str:
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise ConfigError(f"{where}: got {key} = {_short(value)}, wanted one line of text")
    return value


def _short(value: object) -> str:
    """Return a value as it is shown in a message: on one line, and not long."""
    text = value if isinstance(value, str) and value.isprintable() else repr(value)
    return text if len(text) <= 40 else text[:40] + "..."

"""Cameras by name, each a TOML file in presets/ that is read when it is first asked for, and cameras of one's own by path."""

from functools import cache
from importlib import resources
from pathlib import Path

from viewgain.camera._sensor import Sensor
from viewgain.camera._sensor_file import Table, merged, parse, sensor_from_table
from viewgain.errors import ConfigError

PRESETS = (
    "azure_kinect_nfov",
    "azure_kinect_wfov",
    "femto_nfov",
    "femto_wfov",
    "flexx2",
    "kinect_v2",
    "pico_flexx",
    "pico_zense",
    "sick_visionary_t",
    "xtion",
)
"""Names of the cameras that come with the package; each file says where each of its numbers comes from (docs/cameras.md)."""


def sensor(name: str | Path) -> Sensor:
    """Return a preset camera by name, or the camera of a TOML file by its path (docs/cameras.md).

    Raises:
        ConfigError: If the name is no preset and no readable camera file; the message lists the presets or names the key.
    """
    if name in PRESETS:
        return _preset(str(name))
    path = Path(name)
    if path.suffix != ".toml":
        raise ConfigError(f"camera {str(name)!r} is not known; choose one of {', '.join(PRESETS)}, or give a .toml file")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:  # ValueError: not UTF-8, or a path that cannot exist
        raise ConfigError(f"{path}: cannot be read as a camera file: {error}") from error
    return sensor_from_table(_extended(parse(text, str(path)), str(path)), str(path), default_name=path.stem)


@cache
def _preset(name: str) -> Sensor:
    return sensor_from_table(_table(name), f"preset {name}", default_name=name)


def _table(name: str) -> Table:
    """Return the content of a preset file, with what it extends filled in."""
    text = (resources.files("viewgain.camera") / "presets" / f"{name}.toml").read_text(encoding="utf-8")
    return _extended(parse(text, f"preset {name}"), f"preset {name}")


def _extended(content: Table, where: str) -> Table:
    """Return ``content`` laid over the preset that its key ``extends`` names."""
    if "extends" not in content:
        return content
    base = content["extends"]
    if base not in PRESETS:
        raise ConfigError(f"{where}: got extends = {str(base)[:40]!r}, wanted one of {', '.join(PRESETS)}")
    below = {key: value for key, value in _table(str(base)).items() if key != "name"}
    return merged(below, content)

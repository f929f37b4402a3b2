"""A camera as the text of its TOML file: what :func:`viewgain.camera.sensor` reads back to the same camera."""

import numpy as np

from viewgain.camera._sensor import Sensor
from viewgain.camera._sensor_file import FIELDS


def camera_text(sensor: Sensor, *, comment: str = "") -> str:
    """Return the whole camera as TOML, every number written out; reading it gives the same camera to within rounding.

    Args:
        sensor: The camera.
        comment: Lines for the head of the file, without the hash signs.
    """
    lens = sensor.intrinsics
    lines = [f"# {line}" for line in comment.splitlines()]
    lines += [f"name = {_quoted(sensor.name)}", f"kind = {_quoted(sensor.kind)}", "", "[image]"]
    lines += [f"{key} = {getattr(lens, key)}" for key in ("width", "height")]
    lines += [f"{key} = {float(getattr(lens, key))!r}" for key in ("fx", "fy", "cx", "cy")]
    lines += [f"distortion = {[float(number) for number in lens.distortion]}"] if lens.distortion else []
    for section, keys in FIELDS.items():
        lines += ["", f"[{section}]"]
        for key, field in keys.items():
            number = getattr(sensor, field)
            if number is not None:
                lines.append(f"{key} = {float(np.rad2deg(number) if key.endswith('_deg') else number)!r}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'

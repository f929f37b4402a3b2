"""``viewgain calibrate``: one camera's scale and offset from scans of a known box, kept as a camera file."""

import json

import numpy as np

from viewgain.camera import camera_text
from viewgain.cli._commands import Calibrate
from viewgain.cli._files import check, read_floor, read_one
from viewgain.errors import ConfigError
from viewgain.measure import Calibration, calibrate, sensor_of
from viewgain.scans import write_files


def run_calibrate(command: Calibrate) -> int:
    """Measure the known box in every scan, write the camera, and say what was learned."""
    check(command.scans, command.reading)
    if command.out.suffix != ".toml":
        raise ConfigError(f"got --out {command.out}, wanted a .toml file")
    scans = [read_one(path, index, command.reading) for index, path in enumerate(command.scans)]
    found = calibrate(scans, np.array(command.dims), sensor_of(command.reading.camera), floor=read_floor(command.reading))
    sides = " x ".join(f"{side:g}" for side in command.dims)
    comment = f"{found.before.name}, calibrated by viewgain on {len(scans)} scans of a box of {sides} m."
    write_files({command.out: camera_text(found.sensor, comment=comment).encode()})
    print(json.dumps(found.to_dict() | {"out": str(command.out)}) if command.json else _told(found, str(command.out)))
    return 0


def _told(found: Calibration, out: str) -> str:
    """Return what was learned as lines for a terminal: per cent and millimetres."""
    sensor, before = found.sensor, found.before
    scale = f"{100 * sensor.scale:+.2f} % ± {100 * sensor.scale_sd:.2f} % (before: ± {100 * before.scale_sd:.2f} %)"
    offset = f"{1e3 * sensor.offset:+.1f} mm ± {1e3 * sensor.offset_sd:.1f} mm (before: ± {1e3 * before.offset_sd:.1f} mm)"
    end = f"from {found.extents} extents in {found.scans} scans; written to {out}: measure with --camera {out}"
    return f"scale  {scale}\noffset {offset}\n{end}"

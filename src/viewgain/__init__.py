"""viewgain: how big is the box, how sure are we, and where should the depth camera move next?

The public names below load their rooms on first use, so ``import viewgain`` stays quick and light.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from viewgain.camera import Intrinsics as Intrinsics
    from viewgain.camera import Sensor as Sensor
    from viewgain.camera import sensor as sensor
    from viewgain.errors import ConfigError as ConfigError
    from viewgain.errors import ScanError as ScanError
    from viewgain.errors import ViewgainError as ViewgainError
    from viewgain.measure import Measurement as Measurement
    from viewgain.measure import fuse as fuse
    from viewgain.measure import measure as measure
    from viewgain.plan import NextView as NextView
    from viewgain.plan import next_view as next_view
    from viewgain.rigs import RIGS as RIGS
    from viewgain.rigs import Rig as Rig
    from viewgain.rigs import rig as rig
    from viewgain.scans import Scan as Scan
    from viewgain.scans import read_scan as read_scan
    from viewgain.scans import write_scan as write_scan

    __version__: str

_ROOMS = {
    "Intrinsics": "camera",
    "Sensor": "camera",
    "sensor": "camera",
    "ConfigError": "errors",
    "ScanError": "errors",
    "ViewgainError": "errors",
    "Measurement": "measure",
    "fuse": "measure",
    "measure": "measure",
    "NextView": "plan",
    "next_view": "plan",
    "RIGS": "rigs",
    "Rig": "rigs",
    "rig": "rigs",
    "Scan": "scans",
    "read_scan": "scans",
    "write_scan": "scans",
}
__all__ = sorted([*_ROOMS, "__version__"])


def __getattr__(name: str) -> object:
    if name == "__version__":
        return import_module("importlib.metadata").version("viewgain")
    if name not in _ROOMS:
        raise AttributeError(f"module 'viewgain' has no attribute {name!r}")
    value = getattr(import_module(f"viewgain.{_ROOMS[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__

"""Reading the scans that a command names, with their poses and options."""

from pathlib import Path

from viewgain.cli._commands import Reading
from viewgain.errors import ConfigError
from viewgain.scans import Scan, read_scan


def read_one(path: Path, index: int, reading: Reading) -> Scan:
    """Return the ``index``-th scan of a command line."""
    return read_scan(
        path,
        intrinsics=reading.intrinsics,
        amplitude=reading.amplitude,
        min_amplitude=reading.min_amplitude,
        units=reading.units,
        camera_to_world=reading.pose[index] if reading.pose else None,
    )


def read_floor(reading: Reading) -> Scan | None:
    """Return the scan of the empty scene, if one is named."""
    if reading.floor is None:
        return None
    return read_scan(reading.floor, intrinsics=reading.intrinsics, units=reading.units)


def check(scans: tuple[Path, ...], reading: Reading) -> None:
    """Refuse a command line without scans, or with another number of poses than scans.

    Raises:
        ConfigError: Saying which.
    """
    if not scans:
        raise ConfigError("got no scan, wanted at least one file; see viewgain --help")
    if reading.pose and len(reading.pose) != len(scans):
        raise ConfigError(f"got {len(reading.pose)} poses for {len(scans)} scans, wanted one each (or none)")

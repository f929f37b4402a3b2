"""Where the public data lie, if they are there."""

import os
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[1]


def data_folder() -> Path | None:
    """Return the folder of real scans: $VIEWGAIN_DATA or ../shared/data beside the repository; None if absent."""
    return _existing(os.environ.get("VIEWGAIN_DATA"), _ROOT.parent / "shared" / "data")


def boxbench_folder() -> Path | None:
    """Return the folder of boxbench: $VIEWGAIN_BOXBENCH or ../shared/boxbench beside the repository; None if absent."""
    return _existing(os.environ.get("VIEWGAIN_BOXBENCH"), _ROOT.parent / "shared" / "boxbench")


def _existing(named: str | None, usual: Path) -> Path | None:
    folder = Path(named) if named else usual
    return folder if folder.is_dir() else None

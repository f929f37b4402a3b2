"""What a run was made by: versions and revision."""

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("viewgain", "torch", "numpy", "scipy", "safetensors")
"""Whose versions are written down."""


def versions() -> dict[str, Any]:
    """Return the versions of Python and of what computes, and the git revision of the package's own folder, if it is in one."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}, "revision": _revision()}


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _revision() -> str | None:
    folder = Path(__file__).parent
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None

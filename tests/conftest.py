"""What every test shares: a repeatable hypothesis, and the scans that lie beside the checkout but are no part of it."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared"

# The same examples on every run, so a failure comes back; no time limit per example, so a busy machine fails nothing.
settings.register_profile("viewgain", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("viewgain")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark every test that asks for the scans, so that nobody has to remember to."""
    for item in items:
        if {"data_dir", "boxbench_dir"} & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.real_data)


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real scans, meshes and view directions: $VIEWGAIN_DATA, or ../shared/data beside the checkout."""
    return _folder("VIEWGAIN_DATA", SHARED / "data")


@pytest.fixture(scope="session")
def boxbench_dir() -> Path:
    """The folder of simulated scans with known sizes: $VIEWGAIN_BOXBENCH, or ../shared/boxbench beside the checkout."""
    return _folder("VIEWGAIN_BOXBENCH", SHARED / "boxbench")


def _folder(variable: str, default: Path) -> Path:
    """Return the folder; skip without it, but fail where it must be: in CI (or on demand) on a machine that has ../shared."""
    folder = Path(os.environ.get(variable) or default)
    if folder.is_dir():
        return folder
    reason = f"no folder {folder}: put the scans into {default}, or set ${variable} to where they are"
    required = bool(os.environ.get("CI")) or os.environ.get("VIEWGAIN_REQUIRE_DATA") == "1"
    if required and SHARED.is_dir():
        pytest.fail(reason)
    pytest.skip(reason)

"""Truncated and damaged files: one ScanError or (where that is legal) a scan, never anything else."""

from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.errors import ScanError, ViewgainError
from viewgain.scans import Scan, read_scan

POINTS = files.cloud(300)
FORMATS = files.every_format(POINTS) | {"depth.png": files.png(files.counts())}
WHOLE_OR_NOTHING = {"little.ply", "big.ply", "binary.pcd", "compressed.pcd", "cloud.npy", "cloud.npz", "depth.png"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files.put(tmp_path, "intrinsics.json", files.camera_json())
    return tmp_path


def scan_or_error(path: Path) -> Scan | ViewgainError:
    """Read a file; an error must be one of viewgain's, in one printable line that names the file."""
    try:
        return read_scan(path)
    except ViewgainError as caught:
        error = caught
    assert path.name in str(error)
    assert str(error).isprintable()
    return error


@pytest.mark.parametrize("name", FORMATS)
def test_truncation_at_any_byte(folder: Path, name: str) -> None:
    data = FORMATS[name]
    offsets = {0, 1, len(data) - 1, *np.random.default_rng(3).integers(0, len(data), 80), *range(0, min(len(data), 400), 7)}
    for offset in sorted(offsets):
        path = files.put(folder, name, data[:offset])
        scan = scan_or_error(path)
        if isinstance(scan, Scan):
            assert name not in WHOLE_OR_NOTHING, f"{offset} of {len(data)} bytes were taken for a whole file"
            # The last number may have lost digits, which no text format can tell.
            assert len(scan.points) <= len(POINTS)
            np.testing.assert_allclose(scan.points[:-1], POINTS[: len(scan.points) - 1], atol=1e-9)
        else:
            assert isinstance(scan, ScanError)


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_bytes(folder: Path, name: str) -> None:
    rng = np.random.default_rng(11)
    for _ in range(80):
        data = bytearray(FORMATS[name])
        where = rng.integers(0, min(len(data), rng.choice([64, 300, len(data)])), rng.integers(1, 6))
        for offset in where:
            data[offset] = rng.integers(0, 256)
        path = files.put(folder, name, bytes(data))
        scan = scan_or_error(path)
        assert isinstance(scan, ViewgainError) or np.all(np.isfinite(scan.points))


@pytest.mark.parametrize("name", sorted(WHOLE_OR_NOTHING - {"depth.png", "cloud.npz"}))
def test_bytes_after_the_end_do_no_harm(folder: Path, name: str) -> None:
    scan = read_scan(files.put(folder, name, FORMATS[name] + b"\0\0\0\0 trailing"))
    np.testing.assert_array_equal(scan.points, POINTS)

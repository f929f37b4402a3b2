"""The door: how a reader is chosen, what the scan says about itself, what is imported when."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.errors import MissingExtraError, ScanError
from viewgain.scans import read_scan

POINTS = files.cloud()
BINARY = {name: data for name, data in files.every_format(POINTS).items() if name.split(".")[1] in ("ply", "pcd", "npy", "npz")}


@pytest.mark.parametrize("name", sorted(BINARY))
@pytest.mark.parametrize("new_name", ["scan", "scan.dat", "scan.v2"])
def test_an_unknown_extension_is_settled_by_the_first_bytes(tmp_path: Path, name: str, new_name: str) -> None:
    np.testing.assert_allclose(read_scan(files.put(tmp_path, new_name, BINARY[name])).points, POINTS, rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", [str, Path, os.fspath])
def test_paths_of_any_kind(tmp_path: Path, kind: type) -> None:
    path = files.put(tmp_path, "SCAN.NPY", files.npy(POINTS))
    scan = read_scan(kind(path))
    assert scan.source == str(path)


def test_a_name_with_a_line_break_stays_on_one_line(tmp_path: Path) -> None:
    with pytest.raises(ScanError, match=r"a\?b\.ply: no such file"):
        read_scan(tmp_path / "a\nb.ply")


def test_a_link_to_nowhere_and_a_name_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "link.ply").symlink_to(tmp_path / "gone.ply")
    for path in (tmp_path / "link.ply", tmp_path / "nul\0.ply", tmp_path / ("x" * 5000 + ".ply")):
        with pytest.raises(ScanError):
            read_scan(path)


def test_a_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pypcd4", None)
    monkeypatch.setitem(sys.modules, "pypcd4.pypcd4", None)
    path = files.put(tmp_path, "scan.pcd", files.pcd(POINTS))
    with pytest.raises(MissingExtraError, match=r"scan\.pcd: reading \.pcd files needs the package pypcd4"):
        read_scan(path)


def test_importing_the_room_imports_no_decoder() -> None:
    code = "import sys, viewgain.scans; print({'trimesh', 'pypcd4', 'PIL', 'scipy', 'pydantic'} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout == "set()\n"

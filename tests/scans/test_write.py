"""Writing: whole files or nothing, and clear refusals."""

import errno
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.scans import files
from viewgain.errors import ConfigError, ScanError
from viewgain.scans import Scan, read_scan, write_scan

SCAN = Scan.from_range(files.counts() * 0.001, files.CAMERA, camera_to_world=files.POSE)
NAMES = ["scan.ply", "scan.npz", "scan.png"]


def full(*_: Any, **__: Any) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("broken", ["os.replace", "os.fsync", "pathlib.Path.open"])
@pytest.mark.parametrize("existing", [False, True])
def test_a_full_disk_leaves_everything_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, broken: str, existing: bool
) -> None:
    if existing:
        write_scan(SCAN, tmp_path / name, depth_scale=0.0005)
    before = content(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(broken, full)
        with pytest.raises(ScanError, match=r"scan\.\w+: cannot be written \(No space left on device\); check") as caught:
            write_scan(SCAN, tmp_path / name)
    assert str(caught.value).isprintable()
    assert content(tmp_path) == before


@pytest.mark.parametrize("existing", [False, True])
def test_a_disk_that_fills_up_between_two_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, existing: bool) -> None:
    """The sidecar is in place, the image is not: both are taken back."""
    if existing:
        write_scan(SCAN, tmp_path / "scan.png", depth_scale=0.0005)
    before = content(tmp_path)
    replace_file, calls = os.replace, []

    def full_at_second(source: Path, target: Path) -> None:
        calls.append(target)
        if len(calls) == 2:
            full()
        replace_file(source, target)

    with monkeypatch.context() as patch:
        patch.setattr("os.replace", full_at_second)
        with pytest.raises(ScanError, match=r"scan\.png: cannot be written"):
            write_scan(SCAN, tmp_path / "scan.png")
    assert content(tmp_path) == before


@pytest.mark.parametrize("name", NAMES)
def test_an_interrupted_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_scan(SCAN, tmp_path / name)
    assert content(tmp_path) == {}


@pytest.mark.parametrize("name", NAMES)
def test_impossible_folders(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / name).mkdir()
    for path in (tmp_path / "gone" / name, tmp_path / "file" / name, tmp_path / name):
        with pytest.raises(ScanError, match="cannot be written"):
            write_scan(SCAN, path)
    assert sorted(path.name for path in tmp_path.rglob("*")) == sorted(["file", name])


@pytest.mark.parametrize("name", NAMES)
def test_an_old_file_is_replaced_and_nothing_else_appears(tmp_path: Path, name: str) -> None:
    files.put(tmp_path, name, b"old")
    write_scan(SCAN, tmp_path / name)
    write_scan(SCAN, str(tmp_path / name))
    assert set(content(tmp_path)) == {name} | ({"scan.json"} if name.endswith("png") else set())
    np.testing.assert_allclose(read_scan(tmp_path / name).points, SCAN.points, rtol=0, atol=0.0006)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_scan_gives_the_same_bytes(tmp_path: Path, name: str) -> None:
    write_scan(SCAN, tmp_path / name)
    before = content(tmp_path)
    write_scan(SCAN, tmp_path / name)
    assert content(tmp_path) == before


def test_unknown_formats_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScanError, match=r"scan\.pcd: cannot write '\.pcd' files; wanted one of \.ply \.npz \.png"):
        write_scan(SCAN, tmp_path / "scan.pcd")


def test_the_sidecar_says_all(tmp_path: Path) -> None:
    write_scan(SCAN, tmp_path / "scan.png", depth_scale=0.0002, depth_kind="range")
    sidecar = json.loads((tmp_path / "scan.json").read_text())
    assert sidecar["depth_scale"] == 0.0002
    assert sidecar["depth_kind"] == "range"
    assert (sidecar["width"], sidecar["height"], sidecar["fx"]) == (16, 12, 20.0)
    np.testing.assert_allclose(sidecar["camera_to_world"], files.POSE, atol=1e-12)


def test_what_a_depth_image_cannot_hold_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scan.png"
    with pytest.raises(ScanError, match=r"scan\.png: a depth image needs an organised scan with intrinsics"):
        write_scan(Scan.from_array(files.cloud()), path)
    with pytest.raises(ScanError, match="do not fit 16 bits at 1e-05 m per count; choose another depth_scale"):
        write_scan(SCAN, path, depth_scale=1e-5)
    with pytest.raises(ScanError, match="do not fit 16 bits"):
        write_scan(replace(SCAN, points=SCAN.points * 1e-4), path)
    with pytest.raises(ScanError, match="lie behind the camera"):
        write_scan(replace(SCAN, points=-SCAN.points), path)
    with pytest.raises(ScanError, match="pixels off their rays"):
        write_scan(replace(SCAN, points=SCAN.points[::-1].copy()), path)
    for wrong in ({"depth_scale": 0.0}, {"depth_scale": 1.0}, {"depth_scale": float("nan")}, {"depth_kind": "slant"}):
        with pytest.raises(ConfigError, match=r"wanted 1e-6 to 0\.01 and 'z' or 'range'"):
            write_scan(SCAN, path, **wrong)
    assert content(tmp_path) == {}

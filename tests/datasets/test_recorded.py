"""Recordings in folders: which boxes are kept apart, and sizes that are of no folder or missing."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.datasets.engines import Inline
from viewgain.camera import Intrinsics, sensor
from viewgain.datasets import Dataset, add_volume_errors, build, plan_of, recipe, with_target
from viewgain.errors import ConfigError, DataError
from viewgain.scans import write_scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

SMALL = replace(sensor("pico_flexx"), intrinsics=Intrinsics.from_field_of_view(40, 30, *np.deg2rad([62.0, 45.0])))
SIZES = {"big_x": [0.4, 0.3, 0.2], "big_y": [0.4, 0.3, 0.2], "small_x": [0.3, 0.2, 0.2], "small_y": [0.3, 0.2, 0.2]}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two boxes, each recorded by two cameras, a scan from each of two positions."""
    box = standing_box(np.array([0.4, 0.3, 0.2]))
    for view, azimuth in enumerate((0.3, 1.2)):
        scan = capture(Scene((box,)), orbit_pose(box.centre, azimuth, 0.6, 1.0), SMALL, rng=np.random.default_rng(view))
        write_scan(scan, tmp_path / "one.npz")
        for name in SIZES:
            (tmp_path / "recordings" / name / f"{view}").mkdir(parents=True)
            shutil.copy(tmp_path / "one.npz", tmp_path / "recordings" / name / f"{view}" / "a.npz")
    sized(tmp_path / "recordings", SIZES)
    return tmp_path / "recordings"


def sized(folder: Path, sizes: dict[str, list[float]]) -> None:
    (folder / "boxes.toml").write_text("".join(f"{name} = {size}\n" for name, size in sizes.items()))


def apart(folder: Path, name: str = "boxes_recorded") -> set[str]:
    units = plan_of(recipe(name), recordings=folder).units
    return {unit.name.partition("/")[0] for unit in units if unit.splits["other_box"] == "test"}


def test_a_box_that_two_cameras_recorded_is_kept_apart_whole(folder: Path) -> None:
    assert apart(folder) == {"small_x", "small_y"}
    sized(folder, {**SIZES, "small_y": [0.3, 0.2, 0.21]})
    assert apart(folder) == {"small_y"}
    (folder / "boxes.toml").unlink()  # nothing says that two folders are one box
    assert apart(folder) == {"small_y"}


def test_as_published_no_box_is_kept_apart(folder: Path) -> None:
    assert apart(folder, "boxes_recorded_paper") == set()


def test_a_size_without_a_folder_is_refused(folder: Path) -> None:
    sized(folder, {**SIZES, "smal_x": [0.3, 0.2, 0.2]})
    with pytest.raises(ConfigError, match="sizes of smal_x, wanted names of folders"):
        plan_of(recipe("boxes_recorded"), recordings=folder)


def test_sizes_in_millimetres_are_refused(folder: Path) -> None:
    sized(folder, {**SIZES, "big_x": [400, 300, 200]})
    with pytest.raises(ConfigError, match="for big_x, wanted three lengths over 0 and under 10, in metres"):
        plan_of(recipe("boxes_recorded"), recordings=folder)


def test_positions_that_are_called_otherwise_are_refused(folder: Path) -> None:
    (folder / "big_y" / "1").rename(folder / "big_y" / "one")
    with pytest.raises(ConfigError, match="got the positions 0, one, wanted those of big_x: 0, 1"):
        plan_of(recipe("boxes_recorded"), recordings=folder)
    shutil.rmtree(folder / "big_y" / "one")  # fewer are another matter: a network that is told poses takes any number
    assert len(plan_of(recipe("boxes_recorded"), recordings=folder).units) == 7


def test_a_box_without_a_size_has_no_best_position(folder: Path, tmp_path: Path) -> None:
    sized(folder, {name: size for name, size in SIZES.items() if name != "big_y"})
    plan = plan_of(recipe("boxes_recorded_tiny"), recordings=folder)
    build(plan, tmp_path / "out", engine=Inline())
    add_volume_errors(plan, tmp_path / "out", ["lines_published"], engine=Inline())
    with pytest.raises(DataError, match="got no size of big_y; add it"):
        with_target(Dataset(tmp_path / "out"), "histogram:lines_published:soft")


def test_incidence_and_border_are_not_known_of_recordings(folder: Path, tmp_path: Path) -> None:
    sized(folder, SIZES)
    plan = plan_of(recipe("boxes_recorded_tiny"), recordings=folder)
    build(plan, tmp_path / "out", engine=Inline())
    add_volume_errors(plan, tmp_path / "out", ["lines_published"], engine=Inline())
    with pytest.raises(DataError, match="got no boxes of known pose, which incidence and border are of"):
        with_target(Dataset(tmp_path / "out"), "histogram:lines_published:soft+border")

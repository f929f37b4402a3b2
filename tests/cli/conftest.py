"""What commands read: scans of one box from two poses and of a bare floor, also without poses; and a small set of boxes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.datasets.engines import Inline
from tests.oracles.scenes import MODELLED
from viewgain.camera import sensor
from viewgain.datasets import BoxSettings, Dataset, add_volume_errors, build, plan_of, recipe
from viewgain.scans import write_scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

EXTENTS = np.array([0.40, 0.30, 0.20])


@pytest.fixture(scope="session")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scans")
    camera = sensor("pico_flexx").without_systematic()
    box = standing_box(EXTENTS, yaw=0.4)
    target = box.centre
    for name, azimuth in (("one", 0.0), ("two", 2.0)):
        pose = orbit_pose(target, azimuth, np.deg2rad(38), 1.1)
        scan = capture(Scene((box,)), pose, camera, rng=np.random.default_rng(int(10 * azimuth)), effects=MODELLED)
        write_scan(scan, folder / f"{name}.png", depth_scale=1e-4)
        write_scan(scan, folder / f"{name}.ply")
        write_scan(replace(scan, camera_to_world=None), folder / f"{name}_unposed.ply")
        np.savetxt(folder / f"{name}_pose.txt", pose)
    floor = capture(
        Scene(()), orbit_pose(target, 0.0, np.deg2rad(38), 1.1), camera, rng=np.random.default_rng(5), effects=MODELLED
    )
    write_scan(floor, folder / "floor.npz")
    write_scan(replace(floor, camera_to_world=None), folder / "floor_unposed.ply")
    return folder


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Three boxes, of which one is kept apart, four scans from each position."""
    tiny = recipe("boxes_paper_tiny")
    assert isinstance(tiny.content, BoxSettings)
    sizes = ((0.3, 0.2, 0.2), (0.2, 0.4, 0.3), (0.4, 0.3, 0.2))
    content = replace(tiny.content, sizes=sizes, captures=4, captures_per_unit=4, train_captures=3, test_boxes=1)
    folder = tmp_path_factory.mktemp("boxes")
    plan = plan_of(replace(tiny, content=content))
    build(plan, folder, engine=Inline())
    add_volume_errors(plan, folder, ["lines_published"], engine=Inline())
    return Dataset(folder)

"""Scan files on disk for the commands to read: one box from two poses, and a bare floor; also without their poses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.scenes import MODELLED
from viewgain.camera import sensor
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

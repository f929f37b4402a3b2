"""What several posed scans show of what stands on the floor, put together."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.scenes import MODELLED
from viewgain.camera import sensor
from viewgain.errors import ScanError
from viewgain.geometry import inverse, pose, rotation_from_rotvec, transform
from viewgain.parcels import Standing, standing, standing_points, upright_box
from viewgain.scans import Scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

CAMERA = sensor("pico_flexx").without_systematic()
BOX = standing_box(np.array([0.40, 0.30, 0.20]), yaw=0.4)


def scan_from(azimuth: float, scene: Scene | None = None) -> Scan:
    camera = orbit_pose(BOX.centre, azimuth, np.deg2rad(38), 1.1)
    rng = np.random.default_rng(int(10 * azimuth))
    return capture(Scene((BOX,)) if scene is None else scene, camera, CAMERA, rng=rng, effects=MODELLED)


def shown(scan: Scan) -> Standing:
    part = standing(scan, camera=CAMERA)
    assert part is not None
    return part


def test_points_lie_on_the_object_in_the_world() -> None:
    local = transform(inverse(BOX.box_to_camera), shown(scan_from(0.3)).points)
    off = np.linalg.norm(local - np.clip(local, *(BOX.extents * [[-0.5, -0.5, 0], [0.5, 0.5, 1]])), axis=1)
    assert np.quantile(off, 0.95) < 0.01  # the camera's noise at 1.1 m is 7 mm, smoothed


def test_height_and_tilt_are_the_floors_and_not_the_belief() -> None:
    scan = scan_from(0.3)
    assert scan.camera_to_world is not None
    tilted = scan.camera_to_world @ pose(rotation_from_rotvec(np.array([0.05, 0.0, 0.0])), np.zeros(3))
    lifted = pose(np.eye(3), np.array([0.0, 0.0, 0.2])) @ tilted
    one, other = shown(scan), shown(scan.posed(lifted))
    assert np.allclose(one.points, other.points, atol=1e-4)  # tilts turn the heading by their product, some microradians
    moved = shown(scan.posed(pose(np.eye(3), np.array([0.5, -0.2, 0.0])) @ scan.camera_to_world))
    assert np.allclose(moved.points, one.points + np.array([0.5, -0.2, 0.0]), atol=1e-9)


def test_two_scans_from_opposite_sides_hold_the_whole_box() -> None:
    box = upright_box(standing_points([shown(scan_from(0.3)), shown(scan_from(0.3 + np.pi))]))
    assert np.allclose(box.extents, BOX.extents, atol=0.03)


def test_a_point_that_another_scan_looks_through_is_left_out() -> None:
    one, other = shown(scan_from(0.3)), shown(scan_from(0.3 + np.pi / 2))
    stray = BOX.centre + 0.35 * np.array([[np.cos(0.3), np.sin(0.3), 0.0]])
    with_stray = replace(one, points=np.concatenate([one.points, stray]))
    assert np.any(np.all(standing_points([with_stray]) == stray, axis=1))
    together = standing_points([with_stray, other])
    assert not np.any(np.all(together == stray, axis=1))
    inside = replace(one, points=BOX.centre[None])  # hidden from both: nobody looks through it
    assert np.any(np.all(standing_points([inside, other]) == BOX.centre, axis=1))


def test_what_is_lowest_stands_on_the_floor() -> None:
    part = replace(shown(scan_from(0.3)), points=np.array([[0.0, 0.0, 0.03], [0.1, 0.0, 0.045], [0.2, 0.0, 0.3]]))
    points = standing_points([part])
    assert np.allclose(points[3:], [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])


def test_nothing_stands_where_nothing_is() -> None:
    assert standing(scan_from(0.3, Scene(())), camera=CAMERA) is None
    assert standing_points([]).shape == (0, 3)
    with pytest.raises(ScanError, match="camera_to_world"):
        standing(replace(scan_from(0.3), camera_to_world=None), camera=CAMERA)

"""Several scans without camera poses: the box itself says where the cameras stood, and what it cannot say is admitted."""

from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.scenes import CAMERA, WELL_SEEN, corner_view, holds, relative_volume_error, scan_of
from viewgain.box import Box
from viewgain.geometry import inverse, transform
from viewgain.measure import Measurement, fuse, fuse_measurements, measure
from viewgain.measure._match import Extents, correspondences, pooled
from viewgain.scans import Scan, read_scan
from viewgain.scenes import orbit_pose, random_box, standing_box


def lost(scan: Scan, source: str = "lost") -> Scan:
    """The scan without its camera pose."""
    return replace(scan, camera_to_world=None, source=source)


def alone(box: Box, azimuths: tuple[float, ...], rng: np.random.Generator) -> list[Measurement]:
    """Scans of a box from corners, without poses, each measured alone."""
    views = [corner_view(box, azimuth_deg=azimuth, elevation_deg=37) for azimuth in azimuths]
    return [measure(lost(scan_of(box, view=view, rng=rng), f"{k}"), camera=CAMERA) for k, view in enumerate(views)]


def extents(*values: float, sigma: float = 0.004) -> Extents:
    """Three extents, equally well known."""
    return Extents(np.array(values), np.eye(3) / sigma**2, np.array(values) - 1.64 * sigma)


side = st.floats(0.1, 0.6)


@given(side, side, side, st.integers(0, 3))
def test_sides_of_one_box_are_found_whichever_way_it_is_turned(x: float, y: float, z: float, turn: int) -> None:
    one = extents(x, y, z)
    way, agreed = correspondences([one, one.turned(turn)], [0, None])[0]
    np.testing.assert_allclose(agreed.values, [x, y, z], atol=1e-9)
    assert agreed.misfit < 1e-9
    assert way[1] == turn % 2 or abs(x - y) < 1e-6


@given(side, side, side, st.floats(-0.02, 0.02))
def test_pooling_is_the_mean_and_its_misfit_the_chi_square(x: float, y: float, z: float, off: float) -> None:
    both = pooled([extents(x, y, z), extents(x + off, y, z)])
    np.testing.assert_allclose(both.values, [x + off / 2, y, z], atol=1e-9)
    gap = max(abs(off) / 2 - 1.64 * 0.004, 0.0)
    assert abs(both.misfit - (off**2 / 2 / 0.004**2)) <= 1e-6 + 2 * (gap / 0.004) ** 2


def test_an_open_side_is_taken_from_the_other_view_and_its_lower_bound_counts() -> None:
    """0.3 x open x 0.2, at least 0.35 long, can be the 0.3 x 0.5 x 0.2 box and not a 0.3 x 0.25 x 0.2 one."""
    opened = Extents(np.array([0.3, 0.36, 0.2]), np.diag([6e4, 1e-2, 6e4]), np.array([0.29, 0.35, 0.19]))
    assert pooled([opened, extents(0.3, 0.5, 0.2)]).misfit < 0.1
    np.testing.assert_allclose(pooled([opened, extents(0.3, 0.5, 0.2)]).values, [0.3, 0.5, 0.2], atol=1e-3)
    assert pooled([opened, extents(0.3, 0.25, 0.2)]).misfit > 30


@pytest.mark.slow
def test_two_views_without_poses_are_better_than_each_alone_in_the_mean() -> None:
    rng, errors, each, held = np.random.default_rng(31), [], [], []
    for _ in range(12):
        box, first = random_box(rng, WELL_SEEN), float(rng.uniform(0, 360))
        singles = alone(box, (first, first + float(rng.uniform(60, 180))), rng)
        found = fuse_measurements(singles).boxes[0]
        errors.append(abs(relative_volume_error(found, box)))
        each.append(np.mean([abs(relative_volume_error(single.boxes[0], box)) for single in singles]))
        held.append(holds(found.volume_interval90, box.volume))
    assert np.mean(errors) < np.mean(each)
    assert np.median(errors) < 0.008
    assert np.mean(held) >= 0.64  # three standard errors under 90 % for twelve


def test_the_order_of_scans_hardly_matters() -> None:
    """All six orders of three scans: dimensions within 0.5 mm, sigmas within a tenth."""
    singles = alone(standing_box(np.array([0.34, 0.22, 0.27])), (35, 140, 250), np.random.default_rng(32))
    fused = [fuse_measurements(list(order)).boxes[0] for order in permutations(singles)]
    assert np.ptp([box.dimensions for box in fused], axis=0).max() < 5e-4
    assert np.ptp([box.sigma for box in fused], axis=0).max() < 0.1 * max(fused[0].sigma) + 1e-4


def test_the_camera_poses_come_out_up_to_half_a_turn() -> None:
    rng, box = np.random.default_rng(33), standing_box(np.array([0.34, 0.22, 0.27]))
    views = [corner_view(box, azimuth_deg=azimuth) for azimuth in (40, 150)]
    fused = fuse([lost(scan_of(box, view=view, rng=rng)) for view in views], camera=CAMERA)
    assert len(fused.camera_poses) == 2
    np.testing.assert_allclose(fused.camera_poses[1], np.eye(4), atol=1e-9)
    truth = inverse(views[1]) @ views[0]
    half = inverse(views[1]) @ np.diag([-1.0, -1, 1, 1]) @ views[0]
    assert min(np.abs(fused.camera_poses[0] - pose).max() for pose in (truth, half)) < 0.02
    assert any("half a turn" in note for note in fused.notes)


def test_poses_that_carry_nothing_give_what_no_poses_give() -> None:
    """The limit of the other method: with a pose sigma of metres and radians the world poses say nothing."""
    rng, box = np.random.default_rng(34), standing_box(np.array([0.36, 0.24, 0.2]))
    scans = [scan_of(box, view=corner_view(box, azimuth_deg=azimuth), rng=rng) for azimuth in (30, 110)]
    with_poses = fuse(scans, camera=CAMERA, pose_sigma=(5.0, 5.0)).boxes[0]
    without = fuse([lost(scan) for scan in scans], camera=CAMERA).boxes[0]
    np.testing.assert_allclose(without.dimensions, with_poses.dimensions, atol=5e-4)
    np.testing.assert_allclose(without.sigma, with_poses.sigma, rtol=0.1)


def test_a_nearly_square_footprint_covers_both_answers() -> None:
    """Sides 4 mm apart, each view sure of them to 3 mm: whichever way they correspond, the truth is inside."""
    rng, box = np.random.default_rng(35), standing_box(np.array([0.300, 0.304, 0.25]))
    fused = fuse_measurements(alone(box, (40, 140), rng)).boxes[0]
    for ends, truth in zip(fused.interval90[:2], (0.304, 0.300), strict=True):
        assert ends[0] - 0.001 <= truth <= ends[1] + 0.001


def test_two_boxes_are_told_apart_by_size_and_place() -> None:
    rng = np.random.default_rng(36)
    boxes = standing_box(np.array([0.3, 0.2, 0.25]), at=(-0.25, 0.0)), standing_box(np.array([0.2, 0.25, 0.15]), at=(0.25, 0.05))
    views = [orbit_pose(np.array([0, 0, 0.1]), np.deg2rad(azimuth), np.deg2rad(42), 1.4) for azimuth in (-100, -20)]
    fused = fuse([lost(scan_of(*boxes, view=view, rng=rng)) for view in views], camera=CAMERA)
    assert len(fused.boxes) == 2
    assert not any("half a turn" in note for note in fused.notes), "two boxes settle the symmetry"
    np.testing.assert_allclose(fused.camera_poses[0], inverse(views[1]) @ views[0], atol=0.03)
    for box in boxes:
        centre = transform(inverse(views[1]), box.centre)
        nearest = min(fused.boxes, key=lambda found: float(np.linalg.norm(found.box.centre - centre)))
        np.testing.assert_allclose(nearest.dimensions, np.sort(box.extents)[::-1], atol=0.006)


def test_every_view_of_a_box_knows_where_its_camera_stood() -> None:
    """The last scan shows the first box only, so the second is of two other cameras, and told in the frame of that."""
    rng = np.random.default_rng(36)
    boxes = standing_box(np.array([0.3, 0.2, 0.25]), at=(-0.25, 0.0)), standing_box(np.array([0.2, 0.25, 0.15]), at=(0.25, 0.05))
    views = [orbit_pose(np.array([0, 0, 0.1]), np.deg2rad(azimuth), np.deg2rad(42), 1.4) for azimuth in (-100, -20, -60)]
    shown = (boxes, boxes, boxes[:1])
    singles = [measure(lost(scan_of(*some, view=view, rng=rng)), camera=CAMERA) for some, view in zip(shown, views, strict=True)]
    fused = fuse_measurements(singles)
    assert sorted(len(box.views) for box in fused.boxes) == [2, 3]
    for box in fused.boxes:
        for view in box.views:
            centre = view.sees(box.box, np.zeros(6)).centre
            measured = [found.box.centre for single in singles for found in single.boxes if found.views[0].pixels is view.pixels]
            assert min(np.linalg.norm(found - centre) for found in measured) < 0.02


def test_a_scan_of_another_box_is_left_out_and_named() -> None:
    rng = np.random.default_rng(37)
    same = alone(standing_box(np.array([0.3, 0.2, 0.25])), (40, 140), rng)
    (other,) = alone(standing_box(np.array([0.15, 0.4, 0.35])), (40,), rng)
    fused = fuse_measurements([*same[:1], replace(other, scans=("stranger",)), *same[1:]])
    assert fused.camera_poses[1] is None
    assert any("stranger: shares no box" in note for note in fused.notes)
    np.testing.assert_allclose(fused.boxes[0].dimensions, [0.3, 0.25, 0.2], atol=0.005)


def test_the_papers_small_box_from_three_views(data_dir: Path) -> None:
    """Surer than each alone, and within 8 % of what its authors' settings say."""
    names = ("vedere1_small_box.ply", "vedere1.pcd", "vedere2.pcd")
    singles = [measure(read_scan(data_dir / "real_boxes/trai_tof" / name)) for name in names]
    found = fuse_measurements(singles).boxes[0]
    np.testing.assert_allclose(found.volume, 0.0172, rtol=0.08)
    width = np.diff(found.volume_interval90)
    assert all(width < np.diff(single.boxes[0].volume_interval90) for single in singles)


@pytest.mark.slow
def test_two_kinect_scans_of_one_carton(data_dir: Path) -> None:
    scans = [read_scan(data_dir / f"real_boxes/fau_kinect2/example{k}.npz") for k in (1, 2)]
    fused = fuse(scans)
    assert all(pose is not None for pose in fused.camera_poses)
    np.testing.assert_allclose(fused.boxes[0].dimensions, [0.445, 0.353, 0.192], atol=0.02)

"""What scans say, and what the grid makes of it: by hand, against plain rays, and what must not matter."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import voxels as oracle
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import inverse, look_at, transform
from viewgain.scans import Scan
from viewgain.voxels import CERTAIN, OCTOMAP, Evidence, Lattice, OccupancyModel, VoxelGrid, evidence, evidence_of_rays

CUBE = Lattice(np.full(3, -0.5), 0.1, (10, 10, 10))
CAMERA = Intrinsics(width=64, height=48, fx=50.0, fy=50.0, cx=31.5, cy=23.5)
VIEW = look_at(np.array([1.2, 0.3, 0.4]), np.zeros(3), np.array([0.0, 0.0, 1.0]))


def ball(camera_to_world: np.ndarray = VIEW, radius: float = 0.25) -> Scan:
    """An image of a ball at the origin and nothing else."""
    directions = CAMERA.directions()
    centre = inverse(camera_to_world)[:3, 3]
    along = directions @ centre
    inside = along**2 - centre @ centre + radius**2
    ranges = np.where(inside > 0, along - np.sqrt(np.maximum(inside, 0)), np.nan)
    return Scan.from_range(ranges, CAMERA, camera_to_world=camera_to_world)


@pytest.mark.parametrize("empty_is_free", [False, True])
def test_a_scan_says_what_its_rays_say_one_by_one(empty_is_free: bool) -> None:
    scan, origin = ball(), VIEW[:3, 3]
    said = evidence(CUBE, scan, empty_is_free=empty_is_free)
    points = transform(VIEW, scan.points)
    hits, counts = np.unique(CUBE.voxels_of(points), return_counts=True)
    passed = {voxel for point in points for voxel in oracle.passed_voxels(CUBE, origin, point - origin, 1.0)}
    if empty_is_free:
        flags = np.ones(CAMERA.width * CAMERA.height, dtype=bool)
        flags[scan.pixels] = False
        rays = CAMERA.directions().reshape(-1, 3)[flags] @ VIEW[:3, :3].T
        passed |= {voxel for ray in rays[::7] for voxel in oracle.passed_voxels(CUBE, origin, ray)}
        assert passed - set(hits.tolist()) <= set(said.passed.tolist())
    else:
        assert passed - set(hits.tolist()) == set(said.passed.tolist())
    np.testing.assert_array_equal(said.hits, hits)
    np.testing.assert_array_equal(said.returns, counts)
    assert not set(said.hits.tolist()) & set(said.passed.tolist())


def test_behind_the_ball_nothing_is_said_and_beside_it_only_by_empty_pixels() -> None:
    behind, beside = CUBE.voxels_of(np.array([[-0.4, -0.1, -0.13], [0.05, 0.05, 0.43]]))
    for empty_is_free, free in ((False, False), (True, True)):
        grid = VoxelGrid.empty(CUBE).plus([evidence(CUBE, ball(), empty_is_free=empty_is_free)])
        assert grid.unobserved[behind]
        assert grid.free[beside] == free


def test_by_hand_along_one_row() -> None:
    """A return in the fourth voxel of a row, and one far behind the second row."""
    row = Lattice(np.zeros(3), 1.0, (6, 2, 1))
    said = evidence_of_rays(row, np.array([-1.0, 0.5, 0.5]), np.array([[3.5, 0.5, 0.5]]))
    assert (said.hits.tolist(), said.returns.tolist(), said.passed.tolist()) == ([6], [1], [0, 2, 4])
    said = evidence_of_rays(row, np.array([-1.0, 1.5, 0.5]), np.array([[100.0, 1.5, 0.5]]))
    assert (said.hits.tolist(), said.passed.tolist()) == ([], [1, 3, 5, 7, 9, 11])
    grid = VoxelGrid.empty(row).plus([Evidence(np.array([6], np.int32), np.array([3], np.int32), np.array([0, 2], np.int32))] * 2)
    two_hits, two_misses = 0.7**2 / (0.7**2 + 0.3**2), 0.4**2 / (0.4**2 + 0.6**2)
    np.testing.assert_allclose(grid.probability[[6, 0, 2, 4]], [two_hits, two_misses, two_misses, 0.5])
    np.testing.assert_allclose(
        grid.entropy[[4, 0]], [np.log(2), -two_misses * np.log(two_misses) - (1 - two_misses) * np.log(1 - two_misses)]
    )
    assert grid.returns[6] == 6
    assert np.flatnonzero(grid.occupied).tolist() == [6]
    assert np.flatnonzero(grid.free).tolist() == [0, 2]
    assert np.flatnonzero(grid.observed).tolist() == [0, 2, 6]


def test_belief_is_clamped_on_both_sides() -> None:
    said = Evidence(np.array([1], np.int32), np.array([1], np.int32), np.array([0], np.int32))
    for model in (OCTOMAP, CERTAIN, OccupancyModel(hit=0.9, miss=0.1, least=0.05, most=0.95)):
        grid = VoxelGrid.empty(CUBE, model).plus([said] * 50)
        np.testing.assert_allclose(grid.probability[[0, 1]], [model.least, model.most])


def test_a_grid_is_a_value() -> None:
    empty = VoxelGrid.empty(CUBE)
    full = empty.plus([evidence(CUBE, ball())])
    assert np.any(full.observed)
    assert not np.any(empty.observed)
    assert not np.any(empty.log_odds)
    again = full.plus([])
    np.testing.assert_array_equal(again.log_odds, full.log_odds)


@given(st.lists(st.integers(0, 7), min_size=1, max_size=5))
def test_scans_one_after_the_other_and_all_at_once_are_the_same(views: list[int]) -> None:
    said = [
        evidence(CUBE, ball(look_at(np.array([np.cos(v), np.sin(v), 0.3]), np.zeros(3), np.array([0, 0, 1.0])))) for v in views
    ]
    at_once, in_turn = VoxelGrid.empty(CUBE).plus(said), VoxelGrid.empty(CUBE)
    for one in said:
        in_turn = in_turn.plus([one])
    np.testing.assert_array_equal(at_once.log_odds, in_turn.log_odds)
    np.testing.assert_array_equal(at_once.observed, in_turn.observed)
    np.testing.assert_array_equal(at_once.returns, in_turn.returns)


def test_an_unorganised_scan_says_the_same_and_both_backends_do() -> None:
    scan = ball()
    cloud = Scan(points=scan.points, camera_to_world=VIEW)
    said = [evidence(CUBE, scan, backend="numba"), evidence(CUBE, scan, backend="numpy"), evidence(CUBE, cloud)]
    for other in said[1:]:
        for name in ("hits", "returns", "passed"):
            np.testing.assert_array_equal(getattr(other, name), getattr(said[0], name))


def test_with_a_stride_all_returns_hit_and_fewer_rays_free() -> None:
    for scan in (ball(), Scan(points=ball().points, camera_to_world=VIEW)):
        every, some = evidence(CUBE, scan), evidence(CUBE, scan, stride=2)
        np.testing.assert_array_equal(every.hits, some.hits)
        np.testing.assert_array_equal(every.returns, some.returns)
        assert set(some.passed.tolist()) < set(every.passed.tolist())
        assert len(some.passed) > 0.6 * len(every.passed)


def test_the_voxels_that_are_hit_lie_on_the_ball() -> None:
    views = [look_at(eye, np.zeros(3), np.array([0, 0, 1.0])) for eye in np.vstack([np.eye(3), -np.eye(3)])]
    grid = VoxelGrid.empty(CUBE).plus([evidence(CUBE, ball(view), empty_is_free=True) for view in views])
    radius = np.linalg.norm(CUBE.centres, axis=1)
    assert np.all(np.abs(radius[grid.occupied] - 0.25) < 0.1)
    assert np.count_nonzero(grid.occupied) > 40
    assert np.all(grid.unobserved[radius < 0.12])
    assert np.all(grid.free[(radius > 0.4) & (np.abs(CUBE.centres).max(axis=1) < 0.4)])


def test_what_cannot_speak_is_refused() -> None:
    scan = ball()
    with pytest.raises(ScanError, match="pose"):
        evidence(CUBE, replace(scan, camera_to_world=None))
    with pytest.raises(ScanError, match="organised"):
        evidence(CUBE, Scan(points=scan.points, camera_to_world=VIEW), empty_is_free=True)
    for numbers in ({"hit": 0.5}, {"miss": 0.6}, {"least": 0.0}, {"most": 1.0}, {"least": 0.45}, {"most": 0.6}):
        with pytest.raises(ConfigError, match="occupancy"):
            OccupancyModel(**numbers)

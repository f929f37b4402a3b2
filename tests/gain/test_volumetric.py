"""Volumetric metrics: against their sums written out ray by ray, by hand, and by the laws that they obey."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles import voxels as oracle
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.gain import (
    VOLUMETRIC,
    AreaFactor,
    GridKnown,
    Kriegel,
    OcclusionAware,
    ProximityCount,
    RearSideEntropy,
    RearSideVoxel,
    UnobservedVoxel,
)
from viewgain.geometry import look_at, pose
from viewgain.voxels import CERTAIN, OCTOMAP, Evidence, Lattice, OccupancyModel, VoxelGrid, evidence_of_rays

UP = np.array([0.0, 0.0, 1.0])
CAMERA = Intrinsics(width=6, height=5, fx=6.0, fy=6.0, cx=2.5, cy=2.0)
ROW = Lattice(np.zeros(3), 1.0, (6, 1, 1))
ALONG = Intrinsics(width=1, height=1, fx=1.0, fy=1.0, cx=0.0, cy=0.0)
FORTH = look_at(np.array([-1.0, 0.5, 0.5]), np.array([0.0, 0.5, 0.5]), UP)
BACK = look_at(np.array([7.0, 0.5, 0.5]), np.array([0.0, 0.5, 0.5]), UP)
AWAY = look_at(np.array([-1.0, 0.5, 0.5]), np.array([-2.0, 0.5, 0.5]), UP)


def views(count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    eyes = rng.normal(size=(count, 3))
    return np.stack([look_at(1.3 * eye / np.linalg.norm(eye), rng.uniform(-0.2, 0.2, 3), UP) for eye in eyes])


def looked_at(seed: int = 0, scans: int = 2, model: OccupancyModel = CERTAIN) -> VoxelGrid:
    """A grid of 6 x 7 x 8 voxels after a few scans of a blob of points."""
    rng = np.random.default_rng(seed)
    lattice = Lattice(np.array([-0.5, -0.55, -0.6]), 1 / 6, (6, 7, 8))
    blob = rng.normal(size=(40, 3)) * 0.15
    said = []
    for view in views(scans, seed + 100):
        nearer = blob[(blob @ view[:3, 2]) < 0]
        said.append(evidence_of_rays(lattice, view[:3, 3], nearer))
    return VoxelGrid.empty(lattice, model).plus(said)


def rays_of(grid: VoxelGrid, camera: Intrinsics, view: np.ndarray) -> list[list[int]]:
    directions = camera.directions().reshape(-1, 3) @ view[:3, :3].T
    return [oracle.passed_voxels(grid.lattice, view[:3, 3], direction) for direction in directions]


@pytest.mark.parametrize(("seed", "model"), [(0, CERTAIN), (1, OCTOMAP), (2, CERTAIN)])
def test_a_metric_is_its_sum_written_out(seed: int, model: OccupancyModel) -> None:
    grid, candidates = looked_at(seed, model=model), views(3, seed)
    rays = [rays_of(grid, CAMERA, view) for view in candidates]
    for name in sorted(set(VOLUMETRIC) - {"kriegel"}):
        expected = [oracle.metric(name, grid, each) for each in rays]
        assert np.count_nonzero(expected) >= 2, name
        for backend in ("numpy", "numba"):
            gains = VOLUMETRIC[name].gains(GridKnown(grid, candidates, CAMERA, backend))  # type: ignore[arg-type]
            np.testing.assert_allclose(gains, expected, rtol=1e-9, atol=1e-12, err_msg=name)


def known_row(occupied: tuple[int, ...] = (), free: tuple[int, ...] = ()) -> GridKnown:
    said = Evidence(np.array(occupied, np.int32), np.full(len(occupied), 10, np.int32), np.array(free, np.int32))
    return GridKnown(VoxelGrid.empty(ROW, OCTOMAP).plus([said]), np.stack([FORTH, BACK, AWAY]), ALONG)


def test_by_hand_along_one_row() -> None:
    """Six voxels: two free (p = 0.4), one occupied (0.7), three behind it that nobody saw (0.5)."""
    known = known_row(occupied=(2,), free=(0, 1))

    def h(p: float) -> float:
        return float(-p * np.log(p) - (1 - p) * np.log(1 - p))

    forth = h(0.4) * (1 + 0.6) + 0.36 * h(0.7)
    hidden = np.log(2) * (1 + 0.5 + 0.25)
    back = hidden + 0.125 * h(0.7)
    np.testing.assert_allclose(OcclusionAware().gains(known), [forth, back, 0])
    np.testing.assert_allclose(UnobservedVoxel().gains(known), [0, hidden, 0])
    np.testing.assert_allclose(RearSideVoxel().gains(known), [0, 1, 0])
    np.testing.assert_allclose(RearSideEntropy().gains(known), [0, back, 0])
    np.testing.assert_allclose(ProximityCount(reach=3.0).gains(known), [0, 2 + 1 + 0, 0])
    mean_forth, mean_back = (2 * h(0.4) + h(0.7)) / 3, (3 * np.log(2) + h(0.7)) / 4
    np.testing.assert_allclose(VOLUMETRIC["average_entropy"].gains(known), [mean_forth, mean_back, 0])
    np.testing.assert_allclose(AreaFactor().gains(known), [0, 0, 0])  # all rays on known surface is as useless as none
    np.testing.assert_allclose(Kriegel(weight=0).gains(known), np.array([mean_forth, mean_back, 0]) / mean_back)
    np.testing.assert_allclose(Kriegel(weight=1, enough=40).gains(known), [1, 1, 0])


def test_the_row_of_the_rear_side_ends_at_what_was_seen() -> None:
    known = known_row(occupied=(0,), free=(4,))
    h = -0.7 * np.log(0.7) - 0.3 * np.log(0.3)
    row = 0.5 * 0.6 * np.log(2) * (1 + 0.5 + 0.25) + 0.5 * 0.6 * 0.125 * h
    np.testing.assert_allclose(RearSideEntropy().gains(known)[1], row)
    np.testing.assert_allclose(RearSideEntropy().gains(known_row(occupied=(0,), free=(1,))), 0)
    np.testing.assert_allclose(RearSideVoxel().gains(known_row(occupied=(0,), free=(1,))), 0)


def test_the_area_factor_by_hand() -> None:
    """Five rays in a fan onto a lattice whose border is known: one meets the surface, four meet the border of the hidden."""
    lattice = Lattice(np.array([0.0, 0.0, 0.0]), 1.0, (2, 5, 1))
    occupied, free = np.array([0], np.int32), np.array([2, 4, 6, 8], np.int32)
    grid = VoxelGrid.empty(lattice).plus([Evidence(occupied, np.array([1], np.int32), free)])
    camera = Intrinsics(width=5, height=1, fx=100.0, fy=100.0, cx=2.0, cy=0.0)
    view = look_at(np.array([-99.5, 2.5, 0.5]), np.array([0.0, 2.5, 0.5]), UP)
    np.testing.assert_allclose(AreaFactor().gains(GridKnown(grid, view[None], camera)), 2.0)


def test_the_preference_of_the_area_factor_is_the_published_pair_of_cubics() -> None:
    from viewgain.gain._volumetric_area import preference

    shares = np.linspace(0, 1, 201)
    for best in (0.2, 0.5, 0.8):
        np.testing.assert_allclose(preference(shares, best), [oracle.cubic(x, best) for x in shares], atol=1e-12)
        assert preference(np.array([best]), best) == 1


def test_nothing_known_is_the_same_from_everywhere_and_all_known_is_worth_nothing() -> None:
    known = known_row()
    np.testing.assert_allclose(OcclusionAware().gains(known), [np.log(2) * (2 - 2**-5)] * 2 + [0])
    np.testing.assert_allclose(UnobservedVoxel().gains(known), OcclusionAware().gains(known))
    for name in ("rear_side_voxel", "rear_side_entropy", "proximity_count", "average_entropy"):
        np.testing.assert_array_equal(VOLUMETRIC[name].gains(known), 0)
    known = known_row(free=tuple(range(6)))
    for name in ("unobserved_voxel", "rear_side_voxel", "rear_side_entropy", "proximity_count", "average_entropy", "area_factor"):
        np.testing.assert_array_equal(VOLUMETRIC[name].gains(known), 0)


@pytest.mark.parametrize("name", list(VOLUMETRIC))
def test_moving_the_whole_world_by_whole_voxels_changes_nothing(name: str) -> None:
    grid, candidates = looked_at(3), views(4, 3)
    shift = np.array([3.0, -2.0, 5.0]) * grid.lattice.size
    there = replace(grid, lattice=replace(grid.lattice, low=grid.lattice.low + shift))
    moved = pose(np.eye(3), shift) @ candidates
    one, other = (VOLUMETRIC[name].gains(GridKnown(g, c, CAMERA)) for g, c in ((grid, candidates), (there, moved)))
    np.testing.assert_allclose(one, other, rtol=1e-6)


@pytest.mark.parametrize("name", list(VOLUMETRIC))
def test_gains_follow_their_candidates(name: str) -> None:
    grid, candidates, order = looked_at(4), views(5, 4), np.array([3, 0, 4, 2, 1])
    gains = VOLUMETRIC[name].gains(GridKnown(grid, candidates, CAMERA))
    np.testing.assert_array_equal(VOLUMETRIC[name].gains(GridKnown(grid, candidates[order], CAMERA)), gains[order])
    assert gains.shape == (5,)
    assert np.all(np.isfinite(gains))
    assert np.all(gains >= 0)


def test_a_view_from_which_a_scan_was_taken_has_less_unobserved_than_before() -> None:
    lattice, (view,) = Lattice(np.full(3, -0.5), 0.1, (10, 10, 10)), views(1, 5)
    camera = Intrinsics(width=40, height=30, fx=40.0, fy=40.0, cx=19.5, cy=14.5)
    before = GridKnown(VoxelGrid.empty(lattice, CERTAIN), view[None], camera)
    wall = view[:3, 3] + 1.3 * camera.directions().reshape(-1, 3) @ view[:3, :3].T
    after = replace(before, grid=before.grid.plus([evidence_of_rays(lattice, view[:3, 3], wall)]))
    assert UnobservedVoxel().gains(before)[0] > 1000
    assert UnobservedVoxel().gains(after)[0] < 0.05 * UnobservedVoxel().gains(before)[0]  # rays that enter behind the wall
    assert OcclusionAware().gains(after)[0] < 0.6 * OcclusionAware().gains(before)[0]  # a free voxel keeps 0.1 of ln 2 = 0.7


def test_kriegel_prefers_surface_with_few_returns() -> None:
    lattice = Lattice(np.zeros(3), 1.0, (1, 2, 1))
    said = Evidence(np.array([0, 1], np.int32), np.array([5, 80], np.int32), np.zeros(0, np.int32))
    grid = VoxelGrid.empty(lattice).plus([said])
    eyes = [look_at(np.array([-1.0, y, 0.5]), np.array([0.0, y, 0.5]), UP) for y in (0.5, 1.5)]
    known = GridKnown(grid, np.stack(eyes), ALONG)
    np.testing.assert_allclose(Kriegel(weight=1.0).gains(known), [1, (1 - 0.8) / (1 - 0.05)])
    np.testing.assert_allclose(Kriegel(weight=0.0).gains(known), [1, 1])


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(ConfigError, match="candidates"):
        GridKnown(looked_at(), np.eye(4), CAMERA)
    with pytest.raises(ConfigError, match="area factor"):
        AreaFactor(occupied=1.0)
    with pytest.raises(ConfigError, match="kriegel"):
        Kriegel(weight=1.5)

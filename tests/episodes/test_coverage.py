"""Coverage episodes: against sets of samples, by hand, and that the oracle is never beaten by one step."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.oracles.scenes import CAMERA, corner_view
from viewgain.camera import Intrinsics
from viewgain.episodes import (
    CoverageEpisode,
    CoverageOracle,
    CoverageWorld,
    VolumeOracle,
    World,
    run_coverage_episode,
    run_episode,
)
from viewgain.errors import ConfigError
from viewgain.gain import PCNBV, VOLUMETRIC, coverage_auc, coverage_labels, model_clouds, normalised, surface_samples
from viewgain.geometry import transform
from viewgain.plan import FarthestPolicy, Mapper, RandomPolicy, Seen, UniformPolicy, VolumetricPolicy
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.shapes import procedural
from viewgain.voxels import CERTAIN, Lattice

SKETCH = replace(PCNBV, name="sketch", rig="pcnbv16", width=80, height=60, focal=59.5, reach=0.02, surface_points=2000)
"""PC-NBV's protocol with an eighth of the pixels along a side, and as much more reach as the points are farther apart."""


@dataclass(frozen=True)
class Always:
    """Wants one view, then the next, and so on."""

    start: int
    name: str = "always"

    def scores(self, seen: Seen) -> np.ndarray:
        return -((np.arange(len(seen.candidates)) - self.start) % len(seen.candidates)).astype(float)


@pytest.fixture(scope="module")
def worlds() -> list[CoverageWorld]:
    meshes = [procedural(name, rng=np.random.default_rng(seed)) for seed, name in enumerate(("chair", "mug", "car"))]
    return [CoverageWorld.from_mesh(mesh, SKETCH, rng=np.random.default_rng(9)) for mesh in meshes]


def line_world() -> CoverageWorld:
    """Five views in a row, each a cloud of 100 copies of some of ten surface points on a line, out of each other's reach."""
    covers = [[0, 1], [1, 2, 3], [4], [2, 3, 4, 5], [6]]
    surface = np.column_stack([np.arange(10.0), np.zeros(10), np.ones(10)])
    poses = np.stack([np.eye(4)] * 5)
    poses[:, 0, 3] = [0, 10, 20, 30, 40]
    camera = Intrinsics(width=20, height=20, fx=10.0, fy=10.0, cx=9.5, cy=9.5)
    return CoverageWorld.from_clouds(
        [np.repeat(surface[c], 60, axis=0) for c in covers], surface, reach=0.5, poses=poses, camera=camera
    )


def test_coverage_by_hand() -> None:
    world = line_world()
    episode = run_coverage_episode(world, Always(0), first=1, views=4)
    assert episode.order.tolist() == [1, 0, 2, 3]
    np.testing.assert_allclose(episode.union, [0.3, 0.4, 0.5, 0.6])
    np.testing.assert_allclose(episode.published, [0.3, 0.4, 0.5, 0.6])  # no sample lies near points of two places
    np.testing.assert_allclose(episode.auc, (0.3 + 0.4 + 0.5 + 0.3) / 4)


def test_the_oracle_by_hand_with_a_tie() -> None:
    """After view 0 (samples 0, 1): view 3 adds four; then 1 adds none, 2 adds none, 4 adds one."""
    episode = run_coverage_episode(line_world(), CoverageOracle(line_world()), first=0, views=5)
    assert episode.order.tolist() == [0, 3, 4, 1, 2]


def test_an_episode_ends_when_every_view_is_taken_and_none_is_taken_twice() -> None:
    for policy in (Always(2), UniformPolicy(), FarthestPolicy(), RandomPolicy(np.random.default_rng(0))):
        episode = run_coverage_episode(line_world(), policy, first=2, views=99)
        assert sorted(episode.order.tolist()) == [0, 1, 2, 3, 4]
        np.testing.assert_allclose(episode.union[-1], 0.7)


def test_one_view_is_no_question() -> None:
    episode = run_coverage_episode(line_world(), Always(0), first=3, views=1)
    assert episode.order.tolist() == [3]


def test_the_union_is_that_of_the_sets(worlds: list[CoverageWorld]) -> None:
    for world in worlds:
        episode = run_coverage_episode(world, RandomPolicy(np.random.default_rng(1)), first=5, views=8)
        known: set[int] = set()
        for view, share in zip(episode.order, episode.union, strict=True):
            known |= set(np.flatnonzero(world.covered.mask(int(view))).tolist())
            assert share == len(known) / SKETCH.surface_points
        assert np.all(np.diff(episode.union) >= 0)
        assert np.all(episode.published >= episode.union - 1e-12)  # it counts samples at the rims twice
        np.testing.assert_allclose(episode.auc, coverage_auc(episode.union))


def test_an_episode_is_judged_as_the_labels_are() -> None:
    mesh, rng = procedural("teapot", rng=np.random.default_rng(3)), np.random.default_rng(4)
    world = CoverageWorld.from_mesh(mesh, SKETCH, rng=np.random.default_rng(4))
    labels = coverage_labels(
        model_clouds(mesh, SKETCH), surface_samples(normalised(mesh, SKETCH), SKETCH.surface_points, rng=rng), SKETCH, 2
    )
    episode = CoverageEpisode("labels", np.array([2, *labels.order]), world.covered)
    np.testing.assert_allclose(episode.union, labels.coverage_union)
    np.testing.assert_allclose(episode.published, labels.coverage_published)


def test_no_policy_gains_more_in_one_step_than_the_oracle(worlds: list[CoverageWorld]) -> None:
    for world in worlds:
        mapper = Mapper(Lattice(np.full(3, -0.5), 1 / 20, (20, 20, 20)), model=CERTAIN, empty_is_free=True, stride=1, step=2)
        policies = [UniformPolicy(), FarthestPolicy(), *(VolumetricPolicy(metric, mapper) for metric in VOLUMETRIC.values())]
        for first in (0, 7):
            best = run_coverage_episode(world, CoverageOracle(world), first=first, views=2).union[-1]
            assert all(run_coverage_episode(world, policy, first=first, views=2).union[-1] <= best for policy in policies)


def test_the_same_question_has_the_same_answer(worlds: list[CoverageWorld]) -> None:
    lattice = Lattice(np.full(3, -0.5), 1 / 20, (20, 20, 20))
    for metric in VOLUMETRIC.values():
        one, other = (
            run_coverage_episode(worlds[0], VolumetricPolicy(metric, Mapper(lattice, step=2)), first=3, views=4).order
            for _ in range(2)
        )
        np.testing.assert_array_equal(one, other)


def test_scans_are_the_clouds_in_the_cameras_frame_and_images(worlds: list[CoverageWorld]) -> None:
    world = worlds[0]
    clouds = model_clouds(procedural("chair", rng=np.random.default_rng(0)), SKETCH)
    for scan, cloud, view in zip(world.scans, clouds, world.poses, strict=True):
        assert scan is not None
        assert scan.camera_to_world is not None
        np.testing.assert_allclose(scan.camera_to_world, view, atol=1e-12)
        np.testing.assert_allclose(transform(view, scan.points), cloud, atol=1e-12)
        assert scan.shape == (60, 80)
        assert scan.pixels is not None
        pixels = np.column_stack([scan.pixels % 80, scan.pixels // 80])
        np.testing.assert_allclose(SKETCH.camera.project(scan.points), pixels, atol=1e-6)


def test_a_view_of_too_few_points_is_no_scan_but_still_covers() -> None:
    world = line_world()
    few = CoverageWorld.from_clouds(
        [np.array([[5.0, 0.0, 1.0]]), np.zeros((0, 3))],
        np.array([[5.0, 0.0, 1.0]]),
        reach=0.1,
        poses=world.poses[:2],
        camera=world.camera,
    )
    assert few.scans == (None, None)
    seen = few.seen([1, 0])
    assert seen.scans == ()
    assert seen.visited == (1, 0)
    np.testing.assert_allclose(run_coverage_episode(few, Always(0), first=1, views=2).union, [0, 1])


def test_a_cloud_with_two_points_in_a_pixel_is_no_image() -> None:
    assert all(scan is None or scan.shape is None for scan in line_world().scans)


def test_what_makes_no_sense_is_refused() -> None:
    world = line_world()
    for first, views in ((5, 2), (-1, 2), (0, 0)):
        with pytest.raises(ConfigError, match="coverage episode"):
            run_coverage_episode(world, Always(0), first=first, views=views)
    with pytest.raises(ConfigError, match="one pose per cloud"):
        CoverageWorld.from_clouds([np.ones((5, 3))], np.ones((1, 3)), reach=1.0, poses=world.poses, camera=world.camera)


def volume_world() -> World:
    return World(Scene((standing_box(np.array([0.4, 0.3, 0.25])),)), CAMERA)


def test_general_policies_play_volume_episodes() -> None:
    world = volume_world()
    view = corner_view(world.box)
    for policy, name, best in ((UniformPolicy(), "uniform", 4), (FarthestPolicy(), "farthest", 4)):
        episode = run_episode(world, view, rng=np.random.default_rng(0), policy=policy, max_views=2, stop_early=False)
        assert [step.plan.policy for step in episode.steps] == [name, name]
        assert episode.steps[0].plan.best == best
    lattice = Lattice.around(world.box.corners(), voxels=10)
    policy = VolumetricPolicy(VOLUMETRIC["rear_side_voxel"], Mapper(lattice))
    episode = run_episode(world, view, rng=np.random.default_rng(0), policy=policy, max_views=2, stop_early=False)
    assert episode.steps[0].plan.best in (2, 3, 4, 5, 6)


@pytest.mark.slow
def test_the_oracle_of_volume_takes_the_view_that_really_helps() -> None:
    """From low over the floor the top and the depth are open; its choice leaves next to no error."""
    world = volume_world()
    view = orbit_pose(world.box.centre, 0.0, np.deg2rad(11), 1.1)
    oracle = VolumeOracle(world, np.random.default_rng(1))
    episode = run_episode(world, view, rng=np.random.default_rng(0), rig="ring3", policy=oracle, max_views=2, stop_early=False)
    assert [step.plan.policy for step in episode.steps] == ["oracle", "oracle"]
    assert episode.errors[0] > 0.05
    assert episode.errors[1] < 0.03


def test_the_oracle_of_volume_prefers_what_shows_the_box() -> None:
    world = volume_world()
    view = corner_view(world.box)
    scan = world.scan(view, view, np.random.default_rng(0))
    away = view.copy()
    away[:3, :3] = away[:3, :3] @ np.diag([1.0, -1.0, -1.0])  # looks at the sky
    other = corner_view(world.box, azimuth_deg=200.0)
    seen = Seen((scan,), view[None], np.stack([away, other, view]), (2,), CAMERA.intrinsics)
    scores = VolumeOracle(world, np.random.default_rng(1), draws=2).scores(seen)
    assert np.isnan(scores[0])
    assert np.all(scores[1:] < 0)
    assert np.all(scores[1:] > -0.1)
    again = VolumeOracle(world, np.random.default_rng(1), draws=2).scores(seen)
    np.testing.assert_array_equal(scores, again)

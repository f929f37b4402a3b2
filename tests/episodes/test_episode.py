"""The world of an episode and the course of one: what is true, what is believed, and that errors shrink."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.scenes import CAMERA, corner_view
from viewgain.camera import sensor
from viewgain.episodes import Episode, World, run_episode, volume_error
from viewgain.errors import ScanError
from viewgain.geometry import inverse
from viewgain.measure import measure
from viewgain.rigs import Rig, Station
from viewgain.scenes import Scene, orbit_pose, random_box, random_view, standing_box
from viewgain.simulate import Effects, capture


def crate() -> Scene:
    return Scene((standing_box(np.array([0.4, 0.3, 0.25])),))


VIEW = corner_view(crate().boxes[0])


def test_a_scan_of_the_world_is_miscalibrated_and_labelled_with_the_pose_believed_in() -> None:
    perfect = Effects.only()
    far_sighted = replace(CAMERA, range_max=100.0)
    world = World(crate(), far_sighted, scale=0.01, offset=-0.02, effects=perfect)
    believed = orbit_pose(np.zeros(3), 0.1, 0.5, 1.0)
    clean = capture(world.scene, VIEW, far_sighted, rng=np.random.default_rng(0), effects=perfect)
    scan = world.scan(VIEW, believed, np.random.default_rng(0))
    np.testing.assert_allclose(scan.camera_to_world, believed, atol=1e-12)
    expected = np.linalg.norm(clean.points, axis=1) * 1.01 - 0.02
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), expected, rtol=1e-9)


def test_the_camera_arrives_off_by_the_pose_noise_in_place_and_angle() -> None:
    """1,500 draws of three axes each: standard deviations known to 1.1 %; 5 % is over four of them."""
    world, rng = World(crate(), CAMERA, pose_sigma=(0.004, 0.01)), np.random.default_rng(1)
    off = np.array([inverse(VIEW) @ world.arrive(VIEW, rng) for _ in range(1500)])
    np.testing.assert_allclose(off[:, :3, 3].std(), 0.004, rtol=0.05)
    turns = np.stack([off[:, 2, 1] - off[:, 1, 2], off[:, 0, 2] - off[:, 2, 0], off[:, 1, 0] - off[:, 0, 1]]) / 2
    np.testing.assert_allclose(turns.std(), 0.01, rtol=0.05)
    assert np.all(np.abs(off[:, :3, 3].mean(axis=0)) < 4 * 0.004 / np.sqrt(1500))
    assert np.all(np.abs(turns.mean(axis=1)) < 4 * 0.01 / np.sqrt(1500))


def test_a_camera_without_pose_noise_arrives_where_it_was_sent() -> None:
    arrived = World(crate(), CAMERA, pose_sigma=(0.0, 0.0)).arrive(VIEW, np.random.default_rng(0))
    np.testing.assert_allclose(arrived, VIEW, atol=1e-12)


@pytest.fixture(scope="module")
def played() -> list[Episode]:
    """Ten scenes with the default camera's calibration errors, two views each; the first view anywhere from 15 degrees up."""
    camera, episodes = sensor("pico_flexx"), []
    for seed in range(10):
        rng = np.random.default_rng([seed, 7])
        box = random_box(rng)
        world = World(Scene((box,)), camera, rng.normal(0, camera.scale_sd), rng.normal(0, camera.offset_sd))
        episodes.append(run_episode(world, random_view(rng, box), rng=rng, max_views=2, stop_early=False))
    return episodes


@pytest.mark.slow
def test_errors_shrink_from_the_first_view_to_the_last_on_average(played: list[Episode]) -> None:
    first, last = np.array([[episode.errors[0], episode.errors[-1]] for episode in played]).T
    assert last.mean() < first.mean()
    assert np.median(last) < 0.02


@pytest.mark.slow
def test_every_step_carries_its_scan_its_own_measurement_and_all_so_far(played: list[Episode]) -> None:
    for episode in played:
        names = [f"view {k + 1}" for k in range(len(episode.steps))]
        assert [step.scan.source for step in episode.steps] == names
        assert [step.single.scans for step in episode.steps] == [(name,) for name in names]
        assert [step.fused.scans for step in episode.steps] == [tuple(names[: k + 1]) for k in range(len(names))]
        assert all(step.plan.current is step.fused for step in episode.steps)
        assert episode.errors == tuple(volume_error(step.fused, episode.world.box) for step in episode.steps)


@pytest.mark.slow
def test_each_camera_believes_to_be_where_the_plan_before_sent_it(played: list[Episode]) -> None:
    for episode in played:
        for before, after in zip(episode.steps, episode.steps[1:], strict=False):
            sent = before.scan.camera_to_world @ before.plan.candidates[before.plan.best].camera_to_current
            np.testing.assert_allclose(after.scan.camera_to_world, sent, atol=1e-9)


def test_the_stop_rule_ends_an_episode_unless_told_not_to() -> None:
    world = World(crate(), CAMERA)
    stopped = run_episode(world, VIEW, rng=np.random.default_rng(0), tolerance=0.3, max_views=3)
    assert stopped.stopped
    assert len(stopped.steps) == 1
    going_on = run_episode(world, VIEW, rng=np.random.default_rng(0), tolerance=0.3, max_views=2, stop_early=False)
    assert len(going_on.steps) == 2
    np.testing.assert_array_equal(going_on.steps[0].scan.points, stopped.steps[0].scan.points)


def test_one_view_at_most_is_one_view() -> None:
    episode = run_episode(World(crate(), CAMERA), VIEW, rng=np.random.default_rng(0), tolerance=1e-5, max_views=1)
    assert len(episode.steps) == 1
    assert not episode.stopped


def test_it_ends_where_no_station_can_be_reached() -> None:
    cellar = Rig(name="cellar", stations=(Station(elevation=-0.5),))
    episode = run_episode(World(crate(), CAMERA), VIEW, rng=np.random.default_rng(0), rig=cellar, tolerance=1e-5, max_views=4)
    assert len(episode.steps) == 1
    assert episode.steps[0].plan.reason == "no_reachable_view"


def test_it_ends_where_the_next_camera_sees_nothing_and_fails_where_the_first_does() -> None:
    away = orbit_pose(np.array([0.0, 0.0, 3.0]), 0.0, np.deg2rad(-80), 1.5)
    with pytest.raises(ScanError):
        run_episode(World(crate(), CAMERA), away, rng=np.random.default_rng(0))
    sky = Rig(name="sky", stations=(Station(camera_to_world=away),), min_distance=0.0)
    episode = run_episode(World(crate(), CAMERA), VIEW, rng=np.random.default_rng(0), rig=sky, tolerance=1e-5, max_views=3)
    assert len(episode.steps) == 1


def test_the_error_is_that_of_the_volume_and_all_of_it_without_one() -> None:
    measured = measure(capture(crate(), VIEW, CAMERA, rng=None), camera=CAMERA)
    np.testing.assert_allclose(volume_error(measured, standing_box(np.array([0.4, 0.3, 0.25]))), 0, atol=0.01)
    np.testing.assert_allclose(volume_error(measured, standing_box(np.array([0.4, 0.3, 0.5]))), 0.5, atol=0.01)
    np.testing.assert_allclose(volume_error(measured, standing_box(np.array([0.4, 0.3, 0.125]))), 1.0, atol=0.02)
    assert volume_error(replace(measured, boxes=(), reason="not_a_box"), crate().boxes[0]) == 1.0

"""The closed loop: repeatable, ending for a stated reason, and getting surer."""

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.episodes import World, run_episode
from viewgain.plan import RandomPolicy
from viewgain.scenes import Scene, SceneRanges, orbit_pose, random_box, random_view, standing_box

CAMERA = sensor("pico_flexx")


def world_and_view(seed: int) -> tuple[World, np.ndarray]:
    rng = np.random.default_rng(seed)
    box = random_box(rng)
    return World(Scene((box,)), CAMERA), random_view(rng, box, SceneRanges(aim_sd=0.1))


def test_the_same_seed_plays_the_same_episode() -> None:
    world, first = world_and_view(1)
    one, two = (run_episode(world, first, rng=np.random.default_rng(5), max_views=2, stop_early=False) for _ in range(2))
    assert one.errors == two.errors
    assert [s.plan.best for s in one.steps] == [s.plan.best for s in two.steps]
    other = run_episode(world, first, rng=np.random.default_rng(6), max_views=2, stop_early=False)
    assert other.errors != one.errors


def test_it_ends_by_the_stop_rule_or_at_the_limit() -> None:
    world, first = world_and_view(2)
    wide = run_episode(world, first, rng=np.random.default_rng(0), tolerance=0.5, max_views=4)
    assert wide.stopped
    assert len(wide.steps) == 1
    tight = run_episode(world, first, rng=np.random.default_rng(0), tolerance=1e-4, max_views=3)
    assert not tight.stopped
    assert len(tight.steps) == 3
    assert [len(step.fused.scans) for step in tight.steps] == [1, 2, 3]


def test_the_camera_believes_where_it_was_sent_and_stands_elsewhere() -> None:
    world, first = world_and_view(3)
    rng = np.random.default_rng(0)
    arrivals = np.array([world.arrive(first, rng)[:3, 3] - first[:3, 3] for _ in range(400)])
    assert np.std(arrivals) == pytest.approx(world.pose_sigma[0], rel=0.1)
    episode = run_episode(world, first, rng=np.random.default_rng(1), max_views=2, stop_early=False)
    sent = first @ episode.steps[0].plan.candidates[episode.steps[0].plan.best].camera_to_current
    assert np.allclose(episode.steps[1].scan.camera_to_world, sent)


@pytest.mark.slow
def test_a_second_view_helps_and_a_hidden_depth_is_found() -> None:
    gains = []
    for seed in range(10):
        world, first = world_and_view(100 + seed)
        episode = run_episode(world, first, rng=np.random.default_rng(seed), max_views=2, stop_early=False)
        gains.append(episode.errors[0] - episode.errors[-1])
    assert np.mean(gains) > 0
    hidden = World(Scene((standing_box(np.array([0.25, 0.4, 0.35])),)), CAMERA)
    low = orbit_pose(hidden.box.centre, 0.0, np.deg2rad(11), 1.1)
    episode = run_episode(hidden, low, rng=np.random.default_rng(0), max_views=3)
    assert episode.errors[0] > 0.1
    assert episode.errors[-1] < 0.05  # what the stop rule asks for


def test_another_policy_can_decide() -> None:
    world, first = world_and_view(4)
    policy = RandomPolicy(np.random.default_rng(8))
    episode = run_episode(world, first, rng=np.random.default_rng(0), policy=policy, max_views=2, stop_early=False)
    assert {step.plan.policy for step in episode.steps} == {"random"}

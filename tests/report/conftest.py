"""Small closed loops that the tests of this room share: one that closes an open dimension, and two that measure nothing."""

from dataclasses import replace

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.episodes import Episode, Step, World, run_episode
from viewgain.measure import Rejected
from viewgain.plan import next_view
from viewgain.scenes import Scene, orbit_pose, standing_box

CAMERA = sensor("pico_flexx")


def play(
    box: np.ndarray, *, azimuth: float, elevation: float, distance: float, aside: tuple[float, ...] = (0, 0, 0), views: int = 1
) -> Episode:
    """Run the loop on one box whose x axis is the world's; angles in degrees."""
    standing = standing_box(box)
    first = orbit_pose(standing.centre + aside, np.deg2rad(azimuth), np.deg2rad(elevation), distance)
    world = World(Scene((standing,)), CAMERA, 0.002, 0.001)
    return run_episode(world, first, rng=np.random.default_rng(5), max_views=views)


@pytest.fixture(scope="session")
def episode() -> Episode:
    """Two views: one face only, which leaves the depth of 0.25 m open, then a corner."""
    played = play(np.array([0.45, 0.25, 0.30]), azimuth=-90, elevation=6, distance=0.9, views=2)
    assert any(played.steps[0].fused.boxes[0].is_open)
    assert not any(played.steps[1].fused.boxes[0].is_open)
    return played


@pytest.fixture(scope="session")
def blob(episode: Episode) -> Episode:
    """One view in which the object was seen but not measured."""
    step = episode.steps[1]
    estimate = step.single.boxes[0]
    near = Rejected("cut_by_border", 5000, estimate.box.centre, np.array([0.2, 0.15, 0.15]), CAMERA)
    lost = replace(step.single, boxes=(), rejected=(near,), reason="cut_by_border")
    plan = next_view(lost, camera=CAMERA)
    return Episode(episode.world, (Step(step.scan, lost, lost, plan),))


@pytest.fixture(scope="session")
def empty() -> Episode:
    """One view past the box."""
    played = play(np.array([0.1, 0.1, 0.1]), azimuth=20, elevation=50, distance=1.0, aside=(3.0, 0.4, 0.0))
    assert played.steps[0].fused.reason == "nothing_on_floor"
    return played

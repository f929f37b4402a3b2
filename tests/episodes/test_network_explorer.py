"""A network in coverage episodes: what it is shown, and where its scores belong."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.episodes.test_coverage import line_world
from viewgain.episodes import NetworkExplorer, run_coverage_episode
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, transform
from viewgain.inference import ModelCard


class Told:
    """Stands for a network: always the same scores, and remembers what it was asked."""

    def __init__(self, scores: list[float], *, state: bool = False, frame: Any = "object") -> None:
        order: Any = "rig" if state else "present_first"
        self.card = ModelCard(
            name="told", task="none", kind="none", rig="row", views=len(scores), order=order, with_view_state=state, frame=frame
        )
        self._scores = np.array(scores)
        self.asked: list[SimpleNamespace] = []

    def scores(self, points: np.ndarray, state: np.ndarray | None = None, *, seed: int) -> np.ndarray:
        self.asked.append(SimpleNamespace(points=points, state=state, seed=seed))
        return self._scores


def order_of(network: Told, *, first: int, views: int) -> list[int]:
    policy = NetworkExplorer(network, "told")  # type: ignore[arg-type]  # as a network answers
    return run_coverage_episode(line_world(), policy, first=first, views=views).order.tolist()


def test_without_view_state_the_scores_begin_at_the_present_view() -> None:
    """Two views on is best, then three; from 1: 3; from 3: 0; from 0: 2; from 2: 4 (two on), never a visited one."""
    assert order_of(Told([9.0, 0.0, 5.0, 4.0, 0.0]), first=1, views=5) == [1, 3, 0, 2, 4]


def test_with_view_state_the_scores_are_in_rig_order_and_visited_views_are_told() -> None:
    network = Told([1.0, 5.0, 2.0, 4.0, 3.0], state=True)
    assert order_of(network, first=1, views=4) == [1, 3, 4, 2]
    assert [each.state.tolist() for each in network.asked] == [
        [False, True, False, False, False],
        [False, True, False, True, False],
        [False, True, False, True, True],
    ]


@pytest.mark.parametrize("frame", ["object", "camera"])
def test_it_sees_the_clouds_of_all_views_in_its_own_frame(frame: str) -> None:
    world, network = line_world(), Told([0.0, 1.0, 2.0, 3.0, 4.0], frame=frame)
    seen = world.seen([3, 0])
    NetworkExplorer(network, "told").scores(seen)  # type: ignore[arg-type]
    wanted = np.unique(world.covered.points[np.isin(world.covered.view_of_point, [0, 3])], axis=0)
    if frame == "camera":
        wanted = np.unique(transform(inverse(world.poses[0]), wanted), axis=0)
    np.testing.assert_allclose(np.unique(network.asked[0].points, axis=0), wanted, atol=1e-9)


def test_large_clouds_are_drawn_from_all_views_alike() -> None:
    world, network = line_world(), Told([0.0] * 5)
    many = world.seen([3, 1])
    scans = tuple(np.repeat(scan.points, 40, axis=0) for scan in many.scans)
    assert sum(map(len, scans)) > 4096
    many = replace(
        many, scans=tuple(replace(s, points=p, pixels=None, shape=None) for s, p in zip(many.scans, scans, strict=True))
    )
    policy = NetworkExplorer(network, "told")  # type: ignore[arg-type]
    policy.scores(many)
    policy.scores(many)
    first, again = (each.points for each in network.asked)
    assert len(first) == 4096
    assert np.array_equal(first, again)
    share = np.mean(first[:, 0] >= 4)  # samples 4 and 5 are of view 3 alone: 2 of 4 of its points, of 7 in all
    assert share == pytest.approx(2 / 7, abs=0.04)


def test_nothing_seen_is_no_opinion_and_another_rig_is_refused() -> None:
    nothing = line_world().seen([2])
    assert not nothing.scans
    assert np.all(np.isnan(NetworkExplorer(Told([0.0] * 5), "told").scores(nothing)))  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="got 5 candidates"):
        NetworkExplorer(Told([0.0] * 16), "told").scores(nothing)  # type: ignore[arg-type]

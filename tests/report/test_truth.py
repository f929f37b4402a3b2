"""Measured against true: sides are paired by direction, open ones are bounds, and intervals are held against the truth."""

from dataclasses import replace

import numpy as np
import pytest

from viewgain.episodes import Episode
from viewgain.geometry import inverse, pose, rotation_from_rotvec
from viewgain.measure import BoxEstimate
from viewgain.report._truth import compared, true_axes, true_of_reported
from viewgain.scenes import standing_box


def estimate_of(episode: Episode, yaw: float) -> BoxEstimate:
    """The last estimate, turned about the vertical in the world."""
    step = episode.steps[-1]
    to_world = step.fused.world
    turn = to_world @ step.fused.boxes[0].box.box_to_camera
    turned = inverse(to_world) @ turn @ pose(rotation_from_rotvec(np.array([0.0, 0.0, yaw])), np.zeros(3))
    return replace(step.fused.boxes[0], box=replace(step.fused.boxes[0].box, box_to_camera=turned))


@pytest.mark.parametrize("quarter", range(4))
def test_a_quarter_turn_of_the_measured_frame_swaps_its_sides(episode: Episode, quarter: int) -> None:
    world, truth = episode.steps[-1].fused.world, episode.world.box
    straight = true_axes(estimate_of(episode, 0.0), world, truth)
    turned = true_axes(estimate_of(episode, quarter * np.pi / 2), world, truth)
    assert list(turned) == (list(straight) if quarter % 2 == 0 else [straight[1], straight[0], 2])


def test_a_side_that_looks_shorter_than_another_is_still_that_side(episode: Episode) -> None:
    step = episode.steps[0]
    rows = compared(step.fused, episode.world.box)
    assert [row.true for row in rows[:3]] == [0.45, 0.30, 0.25]
    assert [row.is_open for row in rows] == [False, False, True, True]
    assert [row.upright for row in rows] == [False, True, False, False]
    wide = standing_box(np.array([0.45, 0.60, 0.30]))
    renamed = compared(step.fused, wide)
    assert [row.name for row in renamed if row.is_open] == ["Length", "Volume"]
    assert renamed[0].true == 0.60
    np.testing.assert_array_equal(true_of_reported(step.fused.boxes[0], step.fused.world, wide), [0.45, 0.30, 0.60])


def test_reported_and_true_dimensions_go_together(episode: Episode) -> None:
    step, truth = episode.steps[-1], episode.world.box
    estimate = step.fused.boxes[0]
    true = true_of_reported(estimate, step.fused.world, truth)
    np.testing.assert_allclose(estimate.dimensions / true, 1.0, atol=0.03)
    rows = compared(step.fused, truth)
    np.testing.assert_allclose(sorted(row.value for row in rows[:3]), sorted(estimate.dimensions))
    assert rows[3].value == estimate.volume
    assert rows[3].relative_error == pytest.approx(estimate.volume / truth.volume - 1)


def test_an_interval_covers_the_truth_up_to_its_ends(episode: Episode) -> None:
    row = compared(episode.steps[-1].fused, episode.world.box)[0]
    assert replace(row, low=0.4, high=0.5, true=0.4).covered
    assert not replace(row, low=0.4, high=0.5, true=0.51).covered
    assert replace(row, low=0.4, high=None, true=9.0).covered
    assert not replace(row, low=0.4, high=None, true=0.3).covered


def test_nothing_measured_compares_with_nothing(blob: Episode) -> None:
    assert compared(blob.steps[0].fused, blob.world.box) == ()

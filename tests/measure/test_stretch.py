"""The box at other lengths of one side: what moves, what stays, and what the profile of the likelihood says."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.box.cases import boxes
from tests.oracles.scenes import CAMERA, corner_view, scan_of
from viewgain.box import Box
from viewgain.measure import measure
from viewgain.measure._fit import SHARP, Fit, refine
from viewgain.measure._stretch import profile, returned, stretched
from viewgain.scenes import standing_box


def fitted() -> Fit:
    box = standing_box(np.array([0.35, 0.25, 0.3]))
    found = measure(scan_of(box, view=corner_view(box), rng=np.random.default_rng(0)), camera=CAMERA).boxes[0]
    return refine(found.box, found.views, SHARP, 3)


@settings(max_examples=40)
@given(boxes, st.integers(0, 1), st.sampled_from([-1.0, 1.0]), st.floats(0.02, 2.0))
def test_one_end_moves_and_the_other_stays(box: Box, axis: int, side: float, length: float) -> None:
    longer = stretched(box, axis, side, length)
    assert longer.extents[axis] == pytest.approx(length)
    stays, moves = np.zeros((2, 3))
    stays[axis], moves[axis] = -side / 2, side / 2
    for corner, distance in ((stays, 0.0), (moves, abs(length - box.extents[axis]))):
        before, after = (b.box_to_camera[:3, :3] @ (corner * b.extents) + b.box_to_camera[:3, 3] for b in (box, longer))
        assert np.linalg.norm(after - before) == pytest.approx(distance, abs=1e-9)


@settings(max_examples=20)
@given(boxes, st.floats(0.02, 2.0))
def test_a_higher_box_stays_on_its_floor(box: Box, height: float) -> None:
    higher = stretched(box, 2, 1.0, height)
    np.testing.assert_array_equal(higher.box_to_camera, box.box_to_camera)
    assert higher.extents[2] == pytest.approx(height)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_profile_holds_the_length_and_falls_to_both_sides_of_the_fit(axis: int) -> None:
    fit = fitted()
    lengths = fit.box.extents[axis] * np.array([0.8, 0.95, 1.0, 1.05, 1.2])
    tried = profile(fit, axis, lengths, SHARP[0])
    np.testing.assert_allclose([other.box.extents[axis] for other in tried], lengths, atol=1e-12)
    below, near_below, same, near_above, above = (other.value for other in tried)
    assert below < near_below < same
    assert above < near_above < same
    assert same == pytest.approx(fit.value, abs=0.5)


def test_only_returns_are_left() -> None:
    view = fitted().views[0]
    assert np.isnan(view.pixels.ranges).any(), "the scan has missing returns"
    assert np.array_equal(returned(view).pixels.ranges, view.pixels.ranges[np.isfinite(view.pixels.ranges)])

"""Many boxes and poses at once: against one box and one pose at a time, whatever lies behind, beyond or across the image."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.views import View, added_slowly, ends_shown, expected_slowly, relative_slowly, seen_slowly, spanned
from viewgain.box import FACES, Box
from viewgain.camera import sensor
from viewgain.geometry import inverse, pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA, Knowledge
from viewgain.plan import Belief, CovariancePolicy, ExpectedErrorPolicy, predict, showing
from viewgain.plan._error_model import shipped_error_model
from viewgain.plan._showing import showings
from viewgain.scenes import orbit_pose, standing_box

CAMERAS = (sensor("pico_flexx"), sensor("kinect_v2"))
seeds = st.integers(0, 10_000)


def candidate(box: Box, rng: np.random.Generator) -> np.ndarray:
    """A camera about a box: most look at it, some past it or away from it, some from under the floor, some out of range."""
    about = orbit_pose(box.centre, rng.uniform(0, 6.3), rng.uniform(-0.5, 1.5), rng.choice([0.3, 0.6, 1.2, 2.0, 5.0]))
    turned = rng.choice([0.0, 0.1, 0.4, 3.0], p=[0.4, 0.3, 0.2, 0.1])
    return np.asarray(about @ pose(rotation_from_rotvec(turned * rng.normal(size=3)), np.zeros(3)))


def drawn(seed: int) -> tuple[Belief, np.ndarray]:
    """A belief in some boxes, towers among them, and candidates."""
    rng = np.random.default_rng(seed)
    boxes = [standing_box(rng.uniform(0.05, 1.0, 3), yaw=rng.uniform(0, 6.3)) for _ in range(3)]
    here = candidate(boxes[1], rng)
    camera = CAMERAS[seed % 2]
    believed = tuple(box.in_frame(inverse(here)) for box in sorted(boxes, key=lambda box: box.volume))
    known = Knowledge(1e3 * np.eye(9), rng.normal(size=(9, 5)), 1.4)
    poses = np.array([inverse(here) @ candidate(boxes[k % 3], rng) for k in range(5)])
    return Belief(believed, known, camera, rng.uniform(0.7, 2.0), bounded=False), poses


def views_of(belief: Belief, poses: np.ndarray) -> list[Box]:
    return [box.in_frame(inverse(camera)) for box in belief.boxes for camera in poses]


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_what_many_views_show_is_what_each_shows(seed: int) -> None:
    belief, poses = drawn(seed)
    boxes = views_of(belief, poses)
    found = showings(Box.stack(boxes), belief.sensor, belief.noise)
    for index, box in enumerate(boxes):
        wanted, one = seen_slowly(box, belief.sensor, belief.noise), found.take(index)
        largest = np.abs(wanted.knowledge.information).max()
        np.testing.assert_allclose(one.knowledge.information, wanted.knowledge.information, rtol=1e-9, atol=1e-12 * largest)
        largest = np.abs(wanted.knowledge.systematic).max()
        np.testing.assert_allclose(one.knowledge.systematic, wanted.knowledge.systematic, rtol=1e-9, atol=1e-12 * largest)
        np.testing.assert_allclose(one.returns, wanted.returns, rtol=1e-12)
        np.testing.assert_array_equal(one.spanned, spanned(wanted))
        np.testing.assert_allclose(one.ends, ends_shown(wanted), rtol=1e-12)
        for name in ("border", "corners", "clearance", "distance", "elevation"):
            assert float(getattr(one, name)) == pytest.approx(getattr(wanted, name), rel=1e-9, abs=1e-12), name
        assert float(one.floor.returns) == pytest.approx(float(wanted.floor.returns), rel=1e-9)
        assert float(one.floor.share) == pytest.approx(float(wanted.floor.share), rel=1e-9)


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_one_view_is_a_stack_of_one(seed: int) -> None:
    belief, (camera, *_) = drawn(seed)
    box = belief.mean
    wanted = seen_slowly(box.in_frame(inverse(camera)), belief.sensor, belief.noise)
    found, shown = (each(box, camera, belief.sensor, belief.noise) for each in (predict, showing))
    information = wanted.knowledge.information
    np.testing.assert_allclose(found.knowledge.information, information, rtol=1e-9, atol=1e-12 * information.max())
    np.testing.assert_array_equal(shown.knowledge.information, found.knowledge.information)
    assert found.border == pytest.approx(wanted.border, rel=1e-9)
    assert bool(shown.cut) == found.cut == (wanted.border > 0)
    faces = np.flatnonzero(wanted.returns)
    assert [sight.name for sight in found.sights] == [FACES[face] for face in faces]
    assert [sight.returns for sight in found.sights] == pytest.approx(wanted.returns[faces], rel=1e-9)
    assert [sight.incidence for sight in found.sights] == pytest.approx(wanted.incidence[faces], rel=1e-9)


@pytest.mark.parametrize("fused", [True, False])
@settings(max_examples=15, deadline=None)
@given(seed=seeds, glimpsed=st.booleans())
def test_expected_errors_of_many_views_are_those_of_each(fused: bool, seed: int, glimpsed: bool) -> None:
    belief, poses = drawn(seed)
    belief = replace(belief, glimpsed=glimpsed)
    policy = ExpectedErrorPolicy(fused)
    errors = policy.errors(belief, poses)
    for box, row in zip(belief.boxes, errors.tolist(), strict=True):
        for camera, error in zip(poses, row, strict=True):
            wanted, tolerance = error_of(belief, box, camera, fused and not glimpsed)
            assert error == pytest.approx(wanted, rel=tolerance)
    scores = [each.score for each in policy.assess(belief, poses, 0.05)]
    np.testing.assert_allclose(scores, 1 - errors.mean(axis=0), rtol=1e-12)


def rounding(view: View) -> float:
    """How exactly a double can hold what is left of a view: a difference of numbers as large as its information.

    They are as large as the view is near: of a box that fills the image few digits are left, here as there.
    """
    return 1e-9 if np.abs(view.knowledge.information).max() < 1e9 else 1e-4


def error_of(belief: Belief, box: Box, camera: np.ndarray, fused: bool) -> tuple[float, float]:
    """Return the expected error, and how exactly it can be known."""
    there = box.in_frame(inverse(camera))
    view = seen_slowly(there, belief.sensor, belief.noise)
    if not fused:
        return expected_slowly(box, view.knowledge, [view], belief.sensor, shipped_error_model()), rounding(view)
    known = belief.knowledge.plus(added_slowly(view, box, there, POSE_SIGMA))
    views = [seen_slowly(box, belief.sensor, belief.noise), view]
    return expected_slowly(box, known, views, belief.sensor, shipped_error_model()), rounding(view)


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_the_model_scores_many_views_as_it_scores_each(seed: int) -> None:
    """Boxes that are all as likely: the root of the mean variance of their volumes, and the middle one's prediction."""
    belief, poses = drawn(seed)
    found = CovariancePolicy(POSE_SIGMA).assess(belief, poses, 0.05)
    for camera, assessment in zip(poses, found, strict=True):
        sigmas, tolerance = [], 0.0
        for box in belief.boxes:
            there = box.in_frame(inverse(camera))
            view = seen_slowly(there, belief.sensor, belief.noise)
            tolerance = max(tolerance, rounding(view))
            added = added_slowly(view, box, there, POSE_SIGMA)
            sigmas.append(relative_slowly(belief.knowledge.plus(added), box, belief.sensor) * box.volume)
        assert assessment.outlook is not None
        assert assessment.prediction is not None
        assert assessment.outlook.volume_sigma == pytest.approx(float(np.sqrt(np.mean(np.square(sigmas)))), rel=tolerance)
        middle = predict(belief.mean, camera, belief.sensor, belief.noise).knowledge.information
        np.testing.assert_allclose(assessment.prediction.knowledge.information, middle, rtol=1e-9, atol=1e-12 * middle.max())


def test_the_draws_hold_all_that_is_special() -> None:
    """Boxes behind the camera, cut, out of range and whole; cameras above and below the floor."""
    views = [(box, belief) for belief, poses in map(drawn, range(20)) for box in views_of(belief, poses)]
    seen = [seen_slowly(box, belief.sensor, belief.noise) for box, belief in views]
    assert sum(bool(box.corners()[:, 2].min() < 0.05) for box, _ in views) > 10
    assert sum(0 < view.border < 1 for view in seen) > 10
    assert sum(view.border == 0 and not view.returns.any() for view in seen) > 10
    assert sum(view.border == 0 and bool(view.returns.any()) for view in seen) > 10
    assert sum(box.floor.offset < 0 for box, _ in views) > 10
    assert np.mean([rounding(view) == 1e-9 for view in seen]) > 0.5

"""What a view would teach: against a sum over every single pixel, and what it must not depend on."""

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.oracles.scenes import CAMERA
from viewgain.box import FACES, Box, box_hits, entry_mask, floor_hits, range_jacobian
from viewgain.camera import Sensor
from viewgain.geometry import inverse, pose, rotation_from_rotvec
from viewgain.measure import LOOSE_PRIOR, Knowledge
from viewgain.plan import CovariancePolicy, _predict, predict
from viewgain.plan._belief import Belief, normal_within, outlook, relative_sigma
from viewgain.scenes import orbit_pose, standing_box

POSE_SIGMA = (0.003, 0.005)


def seen(extents: list[float], azimuth: float, elevation: float, distance: float) -> Box:
    """A box in the frame of the present camera, which looks at it."""
    box = standing_box(np.array(extents), yaw=0.3)
    return box.in_frame(inverse(orbit_pose(box.centre, np.deg2rad(azimuth), np.deg2rad(elevation), distance)))


def moved_aside(azimuth: float, box: Box) -> np.ndarray:
    """A camera at the other end of an arc about the box, in the present camera's frame."""
    about = (
        box.box_to_camera @ pose(rotation_from_rotvec(np.array([0.0, 0.0, azimuth])), np.zeros(3)) @ inverse(box.box_to_camera)
    )
    return np.asarray(about)


boxes = st.builds(
    seen, st.lists(st.floats(0.15, 0.5), min_size=3, max_size=3), st.floats(0, 360), st.floats(15, 60), st.floats(0.9, 1.5)
)


def by_single_pixels(box: Box, camera: Sensor) -> tuple[np.ndarray, dict[str, float]]:
    """The slow twin: (9, 9) information of every range reading, one pixel after the other, and the returns of each face."""
    rays = camera.intrinsics.directions().reshape(-1, 3)
    hit = entry_mask(box, rays)
    faces, ground = box_hits(box, rays), floor_hits(box, rays)
    corners = camera.intrinsics.project(box.corners())
    low, high = corners.min(axis=0) - 16, corners.max(axis=0) + 16
    v, u = np.divmod(np.arange(len(rays)), camera.intrinsics.width)
    around = (u >= low[0]) & (u <= high[0]) & (v >= low[1]) & (v <= high[1])
    information, returns = np.zeros((9, 9)), dict.fromkeys(FACES, 0.0)
    for hits, chosen in ((faces, hit), (ground, ~hit & around & (ground.ranges < camera.range_max))):
        at = np.flatnonzero(chosen & np.isfinite(hits.ranges))
        own = hits.take(at)
        arriving = 1 - camera.loss(own.cosine)
        trusted = np.where(own.planes < 5, arriving, 1.0)
        weight = arriving * trusted / camera.range_sigma(own.ranges, own.cosine) ** 2
        rows = range_jacobian(box, rays[at], own)
        information += (rows.T * weight) @ rows
        for plane in range(5):
            returns[FACES[plane]] += float(arriving[own.planes == plane].sum())
    return information, returns


def sigmas(information: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information + LOOSE_PRIOR))))


@settings(max_examples=25)
@given(boxes)
@example(seen([0.3125, 0.29296875, 0.25], 0.25, 38.0, 0.90625))  # a few stray pixels graze a side
def test_range_information_is_the_sum_over_every_pixel(box: Box) -> None:
    """A grid of 36 samples a face against some 2,000 pixels: 12 % on each standard deviation."""
    expected, returns = by_single_pixels(box, CAMERA)
    with (
        mock.patch("viewgain.plan._predict.EDGE_INFORMATION", 0.0),
        mock.patch.object(_predict, "_predicted", _predict._predicted.__wrapped__),
    ):
        found = predict(box, np.eye(4), CAMERA, 1.0)  # nothing kept, nor to be kept
    if found.cut or any(0 < count < 100 for count in returns.values()):
        return  # samples near the border, or of a sliver, stand for too many pixels
    if any(sight.returns < 100 or sight.incidence > np.deg2rad(68) for sight in found.sights):
        return  # and so do those where a face begins to be lost
    np.testing.assert_allclose(sigmas(found.knowledge.information), sigmas(expected), rtol=0.12)
    for sight in found.sights:
        np.testing.assert_allclose(sight.returns, returns[sight.name], rtol=0.1, atol=20)


def test_range_information_grows_as_the_inverse_square_of_the_noise() -> None:
    box = seen([0.3, 0.25, 0.2], 40, 35, 1.1)
    once, twice = (predict(box, np.eye(4), CAMERA, noise).knowledge for noise in (1.0, 2.0))
    np.testing.assert_allclose(once.systematic[:, :-1], 4 * twice.systematic[:, :-1], rtol=1e-9)  # the last is of edges


def test_what_is_asked_twice_is_answered_alike_whatever_was_done_to_the_first_answer() -> None:
    placed = pose(rotation_from_rotvec(np.array([2.0, 0.0, 0.0])), np.array([0.0, 0.2, 2.0]))
    boxes = [Box(placed, np.array([1.0, 1.0, side])) for side in (1.0, 2.0)]
    first = [predict(box, np.eye(4), CAMERA, 1.0).knowledge for box in boxes]
    with pytest.raises(ValueError, match="read-only"):
        first[0].information[:] = 0
    with pytest.raises(ValueError, match="read-only"):
        first[0].systematic[:] = 0
    whole = Box(placed, np.array([1, 1, 1]))  # whole numbers mean the same
    for box, known in ((boxes[1], first[1]), (boxes[0], first[0]), (whole, first[0])):
        np.testing.assert_array_equal(predict(box, np.eye(4), CAMERA, 1.0).knowledge.information, known.information)
    others = (
        predict(boxes[0], np.eye(4), CAMERA, 2.0),
        predict(boxes[0], np.eye(4), replace(CAMERA, jitter_px=0.3), 1.0),
        predict(boxes[0], moved_aside(0.5, boxes[0]), CAMERA, 1.0),
    )
    for other in others:
        assert np.any(other.knowledge.information != first[0].information)


@given(boxes, st.floats(-3, 3), st.integers(1, 3))
def test_naming_the_sides_otherwise_changes_no_score(box: Box, azimuth: float, quarters: int) -> None:
    """The same box with its frame turned by quarters: same prediction in the new frame, same score."""
    turn = pose(rotation_from_rotvec(np.array([0.0, 0.0, quarters * np.pi / 2])), np.zeros(3))
    swap = box.extents[[1, 0, 2]] if quarters % 2 else box.extents
    same = Box(box.box_to_camera @ turn, swap)
    change = np.zeros((9, 9))  # a step in the old frame to the step in the new one
    change[:3, :3] = change[3:6, 3:6] = turn[:3, :3].T
    change[6:, 6:] = np.eye(3)[[1, 0, 2]] if quarters % 2 else np.eye(3)
    there = moved_aside(azimuth, box)
    one, other = predict(box, there, CAMERA, 1.2), predict(same, there, CAMERA, 1.2)
    expected = change @ one.knowledge.information @ change.T
    np.testing.assert_allclose(other.knowledge.information, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
    now = predict(box, np.eye(4), CAMERA, 1.2).knowledge
    renamed = Knowledge(change @ now.information @ change.T, change @ now.systematic, now.inflation)
    policy = CovariancePolicy(POSE_SIGMA)
    scores = [
        policy.assess(Belief((shape,), known, CAMERA, 1.2, True), there[None], 0.05)[0].score
        for shape, known in ((box, now), (same, renamed))
    ]
    np.testing.assert_allclose(scores[0], scores[1], atol=1e-6)


@given(boxes, st.floats(-3, 3), st.floats(-3, 3), st.lists(st.floats(-2, 2), min_size=3, max_size=3))
def test_seeing_everything_from_another_frame_changes_no_prediction(
    box: Box, azimuth: float, turn: float, shift: list[float]
) -> None:
    motion = pose(rotation_from_rotvec(np.array([0.2, turn, -0.3])), np.array(shift))
    there = moved_aside(azimuth, box)
    one, other = predict(box, there, CAMERA, 1.0), predict(box.in_frame(motion), motion @ there, CAMERA, 1.0)
    np.testing.assert_allclose(
        other.knowledge.information, one.knowledge.information, rtol=1e-5, atol=1e-6 * np.abs(one.knowledge.information).max()
    )
    assert [sight.name for sight in one.sights] == [sight.name for sight in other.sights]
    assert one.cut == other.cut


@given(boxes, st.floats(-3, 3), st.integers(0, 2))
def test_another_view_never_makes_the_noise_part_of_the_volume_less_certain(box: Box, azimuth: float, more: int) -> None:
    """Noise only: with no systematic error each scan adds information, however useless the view."""
    now = predict(box, np.eye(4), CAMERA, 1.0).knowledge
    after = now
    for _ in range(more + 1):
        after = after.plus(predict(box, moved_aside(azimuth, box), CAMERA, 1.0).knowledge)
    assert relative_sigma(after, box, CAMERA) <= relative_sigma(now, box, CAMERA) * (1 + 1e-9)


@given(boxes, st.floats(-3, 3))
def test_a_score_is_the_share_of_sigma_removed_and_lies_between_nothing_and_all(box: Box, azimuth: float) -> None:
    now = predict(box, np.eye(4), CAMERA, 1.0).knowledge
    belief = Belief((box,), now, CAMERA, 1.0, True)
    (found,) = CovariancePolicy(POSE_SIGMA).assess(belief, moved_aside(azimuth, box)[None], 0.05)
    assert found.outlook is not None
    before = outlook(belief, 0.05)
    np.testing.assert_allclose(found.score, 1 - found.outlook.volume_sigma / before.volume_sigma, atol=1e-9)
    assert -1e-9 <= found.score <= 1
    assert found.outlook.within_tolerance >= before.within_tolerance - 1e-9


@pytest.mark.parametrize(("turn_deg", "cut"), [(0, False), (10, False), (33, True)])
def test_a_box_half_out_of_the_image_is_predicted_cut_and_teaches_less(turn_deg: float, cut: bool) -> None:
    """Turned aside by a third of the field of view the camera sees half the box."""
    box = seen([0.3, 0.3, 0.25], 40, 35, 1.0)
    aside = pose(rotation_from_rotvec(np.deg2rad([0.0, turn_deg, 0.0])), np.zeros(3))
    straight, turned = predict(box, np.eye(4), CAMERA, 1.0), predict(box, aside, CAMERA, 1.0)
    assert turned.cut == cut
    if cut:
        assert sum(sight.returns for sight in turned.sights) < 0.8 * sum(sight.returns for sight in straight.sights)
        assert relative_sigma(turned.knowledge, box, CAMERA) > 2 * relative_sigma(straight.knowledge, box, CAMERA)


def test_beyond_its_range_a_camera_sees_nothing() -> None:
    far = seen([0.3, 0.3, 0.3], 40, 40, 6.0)
    found = predict(far, np.eye(4), CAMERA, 1.0)
    assert found.sights == ()
    assert not found.knowledge.information.any()


def test_sights_name_the_faces_that_are_turned_to_the_camera() -> None:
    """By hand: above a box and off its +x and +y sides, 60 degrees off each face's normal or so."""
    box = standing_box(np.array([0.3, 0.3, 0.3]))
    camera = orbit_pose(box.centre, np.deg2rad(45), np.deg2rad(30), 1.5)
    found = predict(box.in_frame(inverse(camera)), np.eye(4), CAMERA, 1.0)
    assert [sight.name for sight in found.sights] == ["+x", "+y", "top"]
    eye = camera[:3, 3]
    for sight, (centre, normal) in zip(
        found.sights, [([0.15, 0, 0.15], [1, 0, 0]), ([0, 0.15, 0.15], [0, 1, 0]), ([0, 0, 0.3], [0, 0, 1])], strict=True
    ):
        line = eye - centre
        np.testing.assert_allclose(sight.incidence, np.arccos(line @ normal / np.linalg.norm(line)), atol=np.deg2rad(1))


@given(st.floats(-0.2, 0.2), st.floats(0.001, 0.3), st.floats(0.01, 0.3), st.integers(0, 100))
def test_the_chance_to_be_within_tolerance_is_the_share_of_draws(mean: float, sigma: float, tolerance: float, seed: int) -> None:
    """Of 20,000 draws: four standard errors."""
    draws = np.random.default_rng(seed).normal(mean, sigma, 20_000)
    chance = normal_within(mean, sigma, tolerance)
    assert abs(np.mean(np.abs(draws) < tolerance) - chance) < 4 * np.sqrt(max(chance * (1 - chance), 1e-4) / 20_000) + 1e-4


def test_the_outlook_over_several_boxes_is_that_of_a_mixture() -> None:
    """Equally likely boxes, each with its own error: spread and chance by drawing a hundred thousand volumes."""
    shapes = tuple(seen([length, 0.3, 0.25], 40, 35, 1.1) for length in (0.2, 0.3, 0.32, 0.5, 0.9))
    known = predict(shapes[1], np.eye(4), CAMERA, 1.0).knowledge
    belief = Belief(tuple(sorted(shapes, key=lambda box: box.volume)), known, CAMERA, 1.0, False)
    rng = np.random.default_rng(0)
    which = rng.integers(0, 5, 100_000)
    true = np.array([box.volume for box in shapes])[which]
    spread = np.array([relative_sigma(known, box, CAMERA) for box in shapes])[which]
    volumes = true * (1 + spread * rng.standard_normal(100_000))
    found = outlook(belief, 0.1)
    np.testing.assert_allclose(found.volume_sigma, volumes.std(), rtol=0.02)
    middle = float(np.median([box.volume for box in shapes]))
    inside = np.abs(true / middle - 1 + spread * rng.standard_normal(100_000)) < 0.1
    np.testing.assert_allclose(found.within_tolerance, inside.mean(), atol=0.01)

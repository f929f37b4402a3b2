"""Boxes that explain a scan in which nothing was measured: rays against a slow oracle, and whether the true box is among them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewgain.box import Box
from viewgain.box._raycast import box_hits, entry_mask, floor_hits
from viewgain.camera import sensor
from viewgain.geometry import inverse
from viewgain.measure import measure
from viewgain.plan import CombinedPolicy, ExpectedErrorPolicy, FarthestPolicy, OnBelief, Place, Seen, trust
from viewgain.plan._around import reachable_of
from viewgain.plan._possible_boxes import expected_ranges, possible_boxes
from viewgain.rigs import Target, poses, rig
from viewgain.scans import Scan
from viewgain.scenes import Scene, standing_box
from viewgain.simulate import capture

CAMERA = sensor("pico_flexx").without_systematic()
LARGE = standing_box(np.array([1.0, 1.1, 0.56]), yaw=0.5)
STATIONS = poses(rig("irregular4"), Target(LARGE.box_to_camera, LARGE.extents))
UP = np.array([0.0, 0.0, 1.0])


def scan_of(station: int, box: Box = LARGE) -> Scan:
    scan = capture(Scene((box,)), STATIONS[station], CAMERA, rng=np.random.default_rng(3), source="large")
    return scan.posed(STATIONS[station])


@pytest.fixture(scope="module")
def scan() -> Scan:
    """A carton so near that it fills the image: no estimate."""
    return scan_of(2)


def seen_from(scan: Scan) -> Seen:
    assert scan.camera_to_world is not None
    return Seen((scan,), scan.camera_to_world[None], STATIONS, (2,), CAMERA.intrinsics)


@given(
    row=st.tuples(*[st.floats(0.05, 1.2)] * 3, st.floats(0, 1.5), *[st.floats(-1.5, 1.5)] * 2, st.floats(-2.5, -0.8)),
    seed=st.integers(0, 1000),
)
@settings(max_examples=60, deadline=None)
def test_ranges_are_those_of_one_box_after_the_other(row: tuple[float, ...], seed: int) -> None:
    """The oracle walks the visible faces of one box; the fast one knows slabs only."""
    directions = np.random.default_rng(seed).normal(size=(40, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    box = standing_box(np.array(row[:3]), yaw=row[3])
    placed = box.box_to_camera.copy()
    placed[:3, 3] = np.array(row[4:]) - [0, 0, row[2] / 2]
    box = Box(placed, box.extents)
    hit = entry_mask(box, directions)
    wanted = np.minimum(np.where(hit, box_hits(box, directions).ranges, floor_hits(box, directions).ranges), 8.0)
    (found,) = expected_ranges(np.array([row]), directions)
    plain = np.abs(directions[:, 2]) > 1e-5
    assert found[plain] == pytest.approx(wanted[plain], abs=1e-6)


def test_from_within_a_box_every_range_is_nothing() -> None:
    (found,) = expected_ranges(np.array([[1.0, 1.0, 1.0, 0.3, 0.1, 0.1, 0.1]]), np.eye(3))
    assert not found.any()


def test_the_boxes_explain_the_scan_and_the_true_one_is_about_their_middle(scan: Scan) -> None:
    assert not measure(scan, camera=CAMERA).boxes
    assert scan.camera_to_world is not None
    to_camera = inverse(scan.camera_to_world)
    true, up = LARGE.in_frame(to_camera), to_camera[:3, :3] @ UP
    found = possible_boxes(scan.points, up, Place(true.centre, 0.1), 9, rng=np.random.default_rng(0))
    assert len(found) == 9
    volumes = [box.volume for box in found]
    assert volumes == sorted(volumes)
    assert np.mean(volumes) == pytest.approx(LARGE.volume, rel=0.5)
    ranges = np.linalg.norm(scan.points, axis=1)
    directions = scan.points / ranges[:, None]
    for box in found:
        assert box.box_to_camera[:3, 2] == pytest.approx(up, abs=1e-9)
        said = np.where(entry_mask(box, directions), box_hits(box, directions).ranges, floor_hits(box, directions).ranges)
        assert np.median(np.abs(said - ranges)) < 0.05


def test_what_is_seen_stays_and_what_is_not_follows_the_place(scan: Scan) -> None:
    """The top is seen: a middle that lies lower makes the box higher by twice as much."""
    assert scan.camera_to_world is not None
    to_camera = inverse(scan.camera_to_world)
    true, up = LARGE.in_frame(to_camera), to_camera[:3, :3] @ UP
    heights = [
        np.mean([
            box.extents[2]
            for box in possible_boxes(scan.points, up, Place(true.centre + lift * up, 0.02), 50, rng=np.random.default_rng(0))
        ])
        for lift in (-0.1, 0.0, 0.1)
    ]  # fmt: skip
    assert heights == pytest.approx([0.76, 0.56, 0.36], abs=0.06)


@pytest.mark.parametrize("sigma", [0.02, 0.1, 0.5])
def test_a_scan_that_tells_nothing_leaves_what_was_known_before(sigma: float) -> None:
    """Returns from a hundred metres no box explains: centres stay as far spread as the place says, sides as they were drawn."""
    far = np.random.default_rng(0).normal(size=(500, 3))
    far *= 100 / np.linalg.norm(far, axis=1)[:, None]
    found = possible_boxes(far, UP, Place(np.array([0.0, 0.0, 2.0]), sigma), 300, rng=np.random.default_rng(0))
    assert np.std([box.centre for box in found], axis=0) == pytest.approx(sigma, rel=0.15)
    sides = np.array([box.extents for box in found])
    assert sides.mean(axis=0) == pytest.approx(0.625, abs=0.06)
    assert 0.05 <= sides.min() < 0.1 < 1.1 < sides.max() <= 1.2


def test_the_same_draws_give_the_same_boxes_and_others_others(scan: Scan) -> None:
    place = Place(np.array([0.0, 0.0, 0.85]), 0.1)
    up = -np.array([0.0, 0.8, 0.6])
    one, same, other = (possible_boxes(scan.points, up, place, 4, rng=np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert all(np.array_equal(a.box_to_camera, b.box_to_camera) for a, b in zip(one, same, strict=True))
    assert not np.array_equal(one[0].extents, other[0].extents)


def test_told_the_place_there_is_an_opinion_where_nothing_can_be_measured(scan: Scan) -> None:
    """From 85 cm this carton is a wall. Only the second position shows all of it, as the rig's middle gives away."""
    seen = seen_from(scan)
    blind, told = (OnBelief(ExpectedErrorPolicy(fused=False), CAMERA, around=around) for around in (None, 0.1))
    assert np.isnan(blind.scores(seen)).all()
    known = told.measuring(seen)
    belief = told.belief(known)
    assert belief is not None
    assert (belief.guessed, belief.glimpsed, belief.bounded, len(belief.boxes)) == (True, True, False, 9)
    assert told.scores(seen).argmax() == 1
    assert (trust(belief, fused=False), trust(belief, fused=True)) == (0.75, 0.75)


def test_there_is_nothing_to_fuse_with(scan: Scan) -> None:
    seen = seen_from(scan)
    one, other = (OnBelief(ExpectedErrorPolicy(fused=fused), CAMERA, around=0.1).scores(seen) for fused in (True, False))
    assert np.array_equal(one, other)


def test_a_network_is_listened_to_there_as_well(scan: Scan) -> None:
    seen = seen_from(scan)
    model = OnBelief(ExpectedErrorPolicy(fused=False), CAMERA, around=0.1)
    both = CombinedPolicy(model, FarthestPolicy()).scores(seen)
    mean = 0.75 * model.scores(seen) + 0.25 * FarthestPolicy().scores(seen)
    assert np.ptp(both - mean) == pytest.approx(0, abs=1e-9)


def test_candidates_that_look_nowhere_tell_nothing(scan: Scan) -> None:
    scattered = STATIONS.copy()
    scattered[:, :3, 3] += np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [-2, 1, 0]])
    seen = seen_from(scan)
    seen = Seen(seen.scans, seen.stands, scattered, (), CAMERA.intrinsics)
    assert np.isnan(OnBelief(ExpectedErrorPolicy(fused=False), CAMERA, around=0.1).scores(seen)).all()


def test_the_scan_that_was_measured_is_looked_at_not_the_last_one(scan: Scan) -> None:
    """What could not be measured may have been left out; boxes are then sought where the measurement stands."""
    assert scan.camera_to_world is not None
    model = OnBelief(ExpectedErrorPolicy(fused=False), CAMERA, around=0.1)
    alone = model.measuring(seen_from(scan))
    later = replace(alone, scans=(scan, scan_of(1)))
    assert np.array_equal(model.scores(later), model.scores(alone))
    unknown = replace(alone, scans=(scan_of(1),))
    assert np.isnan(model.scores(unknown)).all()


def test_boxes_are_seen_with_the_camera_that_took_the_scan(scan: Scan) -> None:
    """As everywhere: noise and systematic error of the preset, image of the scan."""
    known = OnBelief(ExpectedErrorPolicy(), sensor("kinect_v2"), around=0.1)
    belief = known.belief(known.measuring(seen_from(scan)))
    assert belief is not None
    assert belief.sensor.intrinsics.width == CAMERA.intrinsics.width
    assert belief.sensor.name == "kinect_v2"


def test_a_candidate_keeps_away_from_every_box_that_may_be_there(scan: Scan) -> None:
    """Of measured boxes the smallest is in the way; of guessed ones any may be."""
    model = OnBelief(ExpectedErrorPolicy(), CAMERA, around=0.1)
    belief = model.belief(model.measuring(seen_from(scan)))
    assert belief is not None
    assert scan.camera_to_world is not None
    small = Box(belief.boxes[0].box_to_camera, np.full(3, 0.1))
    large = Box(belief.boxes[0].box_to_camera, np.array([2.6, 2.6, 1.4]))
    known = replace(belief, boxes=(small, large))
    there = inverse(scan.camera_to_world) @ STATIONS
    for glimpsed, allowed in ((False, True), (True, False)):
        reached = reachable_of(there, replace(known, glimpsed=glimpsed), rig("irregular4"), scan.camera_to_world)
        assert reached == (allowed,) * 4


def test_nobody_saw_the_floor_of_a_guessed_box(scan: Scan) -> None:
    """A blob stands on a floor that was measured; how high this one's floor is, is known no better than how high the box is."""
    model = OnBelief(ExpectedErrorPolicy(), CAMERA, around=0.1)
    belief = model.belief(model.measuring(seen_from(scan)))
    assert belief is not None
    sigma = 1 / np.sqrt(np.diag(belief.knowledge.information))
    assert sigma[5] == pytest.approx(sigma[8])
    assert sigma[8] == pytest.approx(np.mean([box.extents[2] for box in belief.boxes]) / 3)


def test_a_box_that_is_measured_is_planned_for_as_without_a_place() -> None:
    small = standing_box(np.array([0.3, 0.25, 0.2]), yaw=0.4)
    stations = poses(rig("irregular4"), Target(small.box_to_camera, small.extents))
    scan = capture(Scene((small,)), stations[0], CAMERA, rng=np.random.default_rng(3)).posed(stations[0])
    seen = Seen((scan,), stations[:1], stations, (0,), CAMERA.intrinsics)
    one, other = (OnBelief(ExpectedErrorPolicy(fused=False), CAMERA, around=around).scores(seen) for around in (None, 0.1))
    assert np.array_equal(one, other)

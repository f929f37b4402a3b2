"""Where the rig says that the box stands: the point its stations look at, and what that leaves of a side nobody sees."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.scenes import UNMIXED
from viewgain.camera import sensor
from viewgain.errors import ConfigError
from viewgain.geometry import look_at, pose, rotation_from_rotvec
from viewgain.measure import BoxEstimate, measure
from viewgain.plan import Place, looked_at, place_amid
from viewgain.plan._believed import belief_from
from viewgain.rigs import Target, poses, rig
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

UP = np.array([0.0, 0.0, 1.0])
CAMERA = sensor("pico_flexx").without_systematic()
EXTENTS = (0.25, 0.4, 0.35)


@pytest.mark.parametrize("name", ["irregular4", "ring8", "hemisphere12"])
@given(motion=st.lists(st.floats(-3, 3), min_size=6, max_size=6))
@settings(max_examples=20, deadline=None)
def test_the_stations_of_a_rig_look_at_its_target_in_every_frame(name: str, motion: list[float]) -> None:
    target = Target.at(np.array([0.3, -0.2, 0.4]), np.array([0.2, 0.5, 0.6]))
    cameras = poses(rig(name), target, elevation=0.6, distance=1.1)
    moved = pose(rotation_from_rotvec(np.array(motion[:3])), np.array(motion[3:]))
    found = looked_at(moved @ cameras)
    assert found is not None
    assert found == pytest.approx(moved[:3, :3] @ target.centre + moved[:3, 3], abs=1e-9)


def cameras_at(*pairs: tuple[tuple[float, float, float], tuple[float, float, float]]) -> np.ndarray:
    return np.stack([look_at(np.array(eye), np.array(at), UP) for eye, at in pairs])


def test_cameras_that_look_at_no_one_point_say_nothing() -> None:
    centre = (0.0, 0.0, 0.2)
    both = cameras_at(((1.0, 0.0, 0.8), centre), ((0.0, 1.0, 0.8), centre))
    assert looked_at(both) == pytest.approx(centre)
    assert looked_at(both[:1]) is None
    assert looked_at(cameras_at(((1.0, 0.0, 0.8), (0.0, 0.0, 0.8)), ((1.0, 0.5, 0.8), (0.0, 0.5, 0.8)))) is None  # parallel
    assert looked_at(cameras_at(((1.0, 0.0, 0.8), (2.0, 0.0, 1.4)), ((0.0, 1.0, 0.8), (0.0, 2.0, 1.4)))) is None  # backs to it
    assert looked_at(cameras_at(((1.0, 0.0, 0.8), centre), ((0.0, 1.0, 0.8), (0.5, 0.0, 0.2)))) is None  # past each other
    assert place_amid(both[:1], 0.1) is None


def test_a_place_is_likeliest_in_its_middle_and_one_sigma_costs_a_half() -> None:
    place = Place(np.array([1.0, 2.0, 3.0]), 0.2)
    odds = place.log_odds(np.array([[1.0, 2.0, 3.0], [1.2, 2.0, 3.0], [1.2, 2.2, 3.0]]))
    assert odds == pytest.approx([0.0, -0.5, -1.0])
    for sigma in (0.0, -1.0, 1e-200, np.inf, np.nan):
        with pytest.raises(ConfigError, match="m, wanted 0"):
            Place(np.zeros(3), sigma)
    for centre in ((np.nan, 0, 0), (0, 1e200, 0), (0, 0)):
        with pytest.raises(ConfigError, match="wanted three numbers of 10000 m at most"):
            Place(np.array(centre), 0.1)


def estimate_of(azimuth: float, elevation: float) -> tuple[BoxEstimate, np.ndarray]:
    """Return a measured box, and its true centre in the camera."""
    box = standing_box(np.array(EXTENTS))
    camera = orbit_pose(box.centre, np.deg2rad(azimuth), np.deg2rad(elevation), 1.1)
    scan = capture(Scene((box,)), camera, CAMERA, rng=np.random.default_rng(1), effects=UNMIXED)
    return measure(scan, camera=CAMERA).boxes[0], np.linalg.inv(camera)[:3] @ np.append(box.centre, 1.0)


def depths(estimate: BoxEstimate, place: Place | None) -> np.ndarray:
    """Return the lengths that are believed of the one open dimension, shortest first."""
    (axis,) = np.flatnonzero(estimate.is_open)
    return np.sort([box.extents[axis] for box in belief_from(estimate, place).boxes])


def test_a_place_says_how_long_an_unseen_side_is() -> None:
    """Face-on and low: the front is seen and the middle is known, so half of the depth is."""
    estimate, centre = estimate_of(0, 11)
    anywhere, here = depths(estimate, None), depths(estimate, Place(centre, 0.02))
    assert len(here) == len(anywhere) == 5
    assert np.ptp(here) < 0.2 < np.ptp(anywhere)
    assert np.median(here) == pytest.approx(EXTENTS[0], abs=0.03)


def test_the_vaguer_the_place_the_wider_and_in_the_end_it_says_nothing() -> None:
    estimate, centre = estimate_of(0, 11)
    spreads = [np.ptp(depths(estimate, Place(centre, sigma))) for sigma in (0.01, 0.05, 0.2, 100.0)]
    assert spreads == sorted(spreads)
    assert depths(estimate, Place(centre, 100.0)) == pytest.approx(depths(estimate, None), rel=0.1)


def test_a_place_farther_behind_the_front_makes_it_deeper_by_twice_as_much() -> None:
    estimate, centre = estimate_of(0, 11)
    (axis,) = np.flatnonzero(estimate.is_open)
    away = estimate.box.box_to_camera[:3, axis]
    away = away * np.sign(away[2])
    near, far = (np.median(depths(estimate, Place(centre + step * away, 0.02))) for step in (0.0, 0.1))
    assert far - near == pytest.approx(0.2, abs=0.05)


def test_a_box_that_stands_elsewhere_is_another_one() -> None:
    """No length brings its centre to a place before its front, nor to one far behind it."""
    estimate, centre = estimate_of(0, 11)
    toward = -centre / np.linalg.norm(centre)
    for step in (0.6, -1.5):
        assert np.array_equal(depths(estimate, Place(centre + step * toward, 0.05)), depths(estimate, None))


def test_what_was_measured_stays() -> None:
    estimate, centre = estimate_of(40, 38)
    assert not any(estimate.is_open)
    (box,) = belief_from(estimate, Place(centre + 0.3, 0.01)).boxes
    assert np.array_equal(box.extents, estimate.box.extents)
    assert np.array_equal(box.box_to_camera, estimate.box.box_to_camera)

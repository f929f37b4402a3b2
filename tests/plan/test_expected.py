"""The expected error of a view: laws, and that it tells views apart as simulated measurements do."""

import numpy as np
import pytest

from viewgain.box import Box
from viewgain.camera import sensor
from viewgain.geometry import inverse, look_at
from viewgain.measure import measure
from viewgain.plan import (
    ExpectedErrorPolicy,
    FarthestPolicy,
    MeanPolicy,
    OnBelief,
    Seen,
    expected_error,
    fused_expected_error,
    showing,
)
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

UP = np.array([0.0, 0.0, 1.0])
CAMERA = sensor("pico_flexx")
BOX = standing_box(np.array([0.3, 0.25, 0.2]), yaw=0.4)


def view(azimuth: float, *, elevation: float = 0.6, distance: float = 1.2, box: Box = BOX) -> np.ndarray:
    return orbit_pose(box.centre, azimuth, elevation, distance)


def test_it_is_a_share_and_a_scan_that_sees_nothing_is_a_miss() -> None:
    assert 0 < expected_error(BOX, view(0.3), CAMERA) < 0.1
    away = look_at(np.array([1.0, 1.0, 1.0]), np.array([5.0, 5.0, 1.0]), UP)
    assert expected_error(BOX, away, CAMERA) == pytest.approx(1.0, abs=1e-3)


def test_it_is_the_same_in_every_frame() -> None:
    camera, other = view(0.7), view(2.9, elevation=1.0)
    moved = expected_error(BOX.in_frame(inverse(other)), inverse(other) @ camera, CAMERA)
    assert moved == pytest.approx(expected_error(BOX, camera, CAMERA), rel=1e-6)


def test_a_cut_box_is_worse_and_worst_where_an_end_is_out_of_sight() -> None:
    long = standing_box(np.array([2.0, 0.4, 0.4]))
    far, near = (expected_error(long, view(np.pi / 2, distance=distance, box=long), CAMERA) for distance in (2.6, 1.3))
    assert far < 0.2 < 0.9 < near


def test_noise_and_distance_never_help_a_small_box() -> None:
    small = standing_box(np.array([0.06, 0.06, 0.06]))
    errors = [expected_error(small, view(0.7, distance=distance, box=small), CAMERA) for distance in (0.7, 1.2, 2.0, 3.0)]
    assert errors == sorted(errors)
    assert expected_error(BOX, view(0.7), CAMERA, 4.0) > expected_error(BOX, view(0.7), CAMERA, 1.0)


def test_fusing_helps_and_another_side_helps_most() -> None:
    present = view(0.4)
    here = BOX.in_frame(inverse(present))
    first = showing(here, np.eye(4), CAMERA, 1.0)
    alone = expected_error(here, np.eye(4), CAMERA)
    again, opposite = (
        fused_expected_error(here, first, inverse(present) @ view(azimuth), CAMERA) for azimuth in (0.4, 0.4 + np.pi)
    )
    assert opposite < again < alone


def test_spanned_axes_are_those_whose_ends_can_be_seen() -> None:
    assert showing(BOX, view(0.4), CAMERA, 1.0).spanned.all()
    overhead = showing(BOX, view(0.4, elevation=np.pi / 2 - 0.01), CAMERA, 1.0)
    assert overhead.spanned[:2].all()
    long = standing_box(np.array([3.0, 0.3, 0.3]))
    seen = showing(long, view(np.pi / 2, box=long), CAMERA, 1.0)
    assert seen.cut
    assert not seen.spanned[0]
    assert seen.spanned[2]


def test_the_policy_ranks_by_the_box_that_was_measured_and_the_mean_takes_whoever_has_an_opinion() -> None:
    present = view(0.5)
    scan = capture(Scene((BOX,)), present, CAMERA, rng=np.random.default_rng(0)).posed(present)
    candidates = np.stack([view(0.5), view(0.5, distance=0.45), view(2.0)])
    seen = Seen((scan,), present[None], candidates, (0,), CAMERA.intrinsics)
    policy = OnBelief(ExpectedErrorPolicy(fused=False), CAMERA)
    scores = policy.scores(seen)
    truth = np.array([1 - expected_error(BOX, camera, CAMERA) for camera in candidates])
    assert np.argsort(scores).tolist() == np.argsort(truth).tolist()
    assert measure(scan, camera=CAMERA).boxes
    blind = Seen((), present[None], candidates, (0,), CAMERA.intrinsics)
    mean = MeanPolicy(policy, FarthestPolicy(), weight=0.25)
    far = FarthestPolicy().scores(seen)
    assert mean.scores(seen) == pytest.approx(0.25 * scores + 0.75 * far)
    assert mean.scores(blind) == pytest.approx(far)

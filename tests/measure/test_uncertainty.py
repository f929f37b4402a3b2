"""From information to error bars: marginals against dense algebra, several sources, edges that shift, noise that is alike."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.scenes import CAMERA, WELL_SEEN, scan_of
from viewgain.camera import sensor
from viewgain.evaluation import VolumeSettings
from viewgain.evaluation._volume_case import volume_case
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import (
    LOOSE_PRIOR,
    SYSTEMATIC,
    Knowledge,
    _uncertainty,
    marginal,
    measure,
    pose_precision,
    without_edge_bias,
)
from viewgain.measure._fit import SHARP, Fit
from viewgain.measure._stretch import CLEARLY, LEVEL, fall, of_few_pixels
from viewgain.measure._uncertainty import COMMON_EDGES, interval_of_profile
from viewgain.scans import Scan
from viewgain.scenes import random_box, random_view

seeds = st.integers(0, 10_000)


def information(rng: np.random.Generator, rows: int = 40) -> np.ndarray:
    """A random (9, 9) information matrix of full rank, with units as unlike as radians and metres are."""
    design = rng.normal(size=(rows, 9)) * np.geomspace(1, 1e3, 9)
    return np.asarray(design.T @ design)


@given(seeds, st.floats(1e-3, 1e3))
def test_a_pose_error_integrated_out_is_the_block_of_the_joint_inverse(seed: int, size: float) -> None:
    """Schur complement against the inverse of the joint (15, 15) information of box and pose error."""
    rng = np.random.default_rng(seed)
    box, systematic = information(rng), rng.normal(size=(9, SYSTEMATIC))
    precision = size * (np.eye(6) + 0.1 * np.ones((6, 6)))
    joint = np.block([[box, box[:, :6]], [box[:6], box[:6, :6] + precision]])
    found, shifted = marginal(box, systematic, precision)
    np.testing.assert_allclose(np.linalg.inv(found), np.linalg.inv(joint)[:9, :9], rtol=1e-5)
    both = np.linalg.inv(joint) @ np.vstack([systematic, systematic[:6]])
    np.testing.assert_allclose(np.linalg.inv(found) @ shifted, both[:9], rtol=1e-4, atol=1e-9)


def test_an_exact_pose_changes_nothing_and_an_unknown_one_leaves_the_extents() -> None:
    rng = np.random.default_rng(0)
    box, systematic = information(rng), rng.normal(size=(9, SYSTEMATIC))
    np.testing.assert_array_equal(marginal(box, systematic, None)[0], box)
    np.testing.assert_allclose(marginal(box, systematic, 1e15 * np.eye(6))[0], box, rtol=1e-3)
    lost = marginal(box, systematic, 1e-9 * np.eye(6))[0]
    np.testing.assert_allclose(lost[:6], 0, atol=1e-6 * np.abs(box).max())
    expected = np.linalg.inv(np.linalg.inv(box)[6:, 6:])
    np.testing.assert_allclose(lost[6:, 6:], expected, rtol=1e-5)


@given(seeds, st.floats(0.01, 2))
def test_edges_that_may_be_shifted_are_the_block_of_the_joint_inverse(seed: int, sd: float) -> None:
    """Each edge with its own offset: against the inverse of the joint information of the box and all offsets."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(6, 9)) * np.geomspace(1, 100, 9)  # six edges, one row each: pixels of shift per step of the box
    weight = rng.uniform(1, 1000, 6)
    base = information(rng)
    box = base + (rows.T * weight) @ rows
    pull = rows * weight[:, None]
    joint = np.block([[box, pull.T], [pull, np.diag(weight + 1 / sd**2)]])
    found = without_edge_bias(box, pull, weight, sd)
    np.testing.assert_allclose(np.linalg.inv(found), np.linalg.inv(joint)[:9, :9], rtol=1e-5)


def test_an_edge_known_to_be_where_it_is_shown_loses_nothing() -> None:
    rng = np.random.default_rng(1)
    rows, weight = rng.normal(size=(6, 9)), rng.uniform(1, 10, 6)
    box = information(rng) + (rows.T * weight) @ rows
    np.testing.assert_allclose(without_edge_bias(box, rows * weight[:, None], weight, 0.0), box, rtol=1e-6)


@given(seeds)
def test_what_two_scans_say_adds_up(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (Knowledge(information(rng), rng.normal(size=(9, SYSTEMATIC)), rng.uniform(1, 3)) for _ in range(2))
    both = first.plus(second)
    np.testing.assert_allclose(both.information, first.information + second.information)
    np.testing.assert_allclose(both.systematic, first.systematic + second.systematic)
    assert both.inflation == max(first.inflation, second.inflation)
    noise_only = replace(CAMERA, scale_sd=0.0, offset_sd=0.0)
    same = replace(second, inflation=first.inflation)
    gain = first.covariance(noise_only) - first.plus(same).covariance(noise_only)
    assert np.linalg.eigvalsh(gain)[0] > -1e-9 * np.linalg.eigvalsh(gain)[-1], "another scan never makes anything less certain"


@given(seeds, st.floats(0, 0.01), st.floats(0, 0.01))
def test_the_covariance_is_noise_inflated_plus_calibration(seed: int, scale_sd: float, offset_sd: float) -> None:
    """Against a sum over the two errors, each of them a shift of the estimate by its own response."""
    rng = np.random.default_rng(seed)
    known = Knowledge(information(rng), 1e3 * rng.normal(size=(9, SYSTEMATIC)), 1.7)
    camera = replace(CAMERA, scale_sd=scale_sd, offset_sd=offset_sd, wiggle=0.002, spread=1.3)
    inverse = np.linalg.inv(known.information + LOOSE_PRIOR)
    deviations = (scale_sd, offset_sd, 0.002 / np.sqrt(2), 0.002 / np.sqrt(2), COMMON_EDGES)
    shifts = [inverse @ column * deviation for column, deviation in zip(known.systematic.T, deviations, strict=True)]
    expected = 1.7 * 1.3**2 * inverse + sum(np.outer(shift, shift) for shift in shifts)
    np.testing.assert_allclose(known.covariance(camera), expected, rtol=1e-9, atol=1e-18)


def test_nothing_known_is_the_loose_prior() -> None:
    spread = Knowledge(np.zeros((9, 9)), np.zeros((9, SYSTEMATIC))).covariance(replace(CAMERA, spread=1.0))
    np.testing.assert_allclose(np.sqrt(np.diag(spread)), [1, 1, 1, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5])


def test_pose_errors_move_the_box_by_lever_arm_times_angle() -> None:
    """A camera a metre away that is off by 0.01 rad misplaces the box by 1 cm across the line of sight; sampled."""
    camera_to_box = pose(rotation_from_rotvec(np.array([0.3, -0.2, 0.5])), np.array([0.0, 0.0, 1.0]))
    exact = pose(np.eye(3), np.zeros(3))
    spread = np.linalg.inv(pose_precision(camera_to_box, exact, (1e-6, 0.01)))
    rng, samples = np.random.default_rng(1), []
    for _ in range(4000):
        for_camera, for_reference = (pose(rotation_from_rotvec(rng.normal(0, 0.01, 3)), np.zeros(3)) for _ in range(2))
        moved = for_reference @ camera_to_box @ for_camera @ np.linalg.inv(camera_to_box)
        rotvec = np.array([moved[2, 1] - moved[1, 2], moved[0, 2] - moved[2, 0], moved[1, 0] - moved[0, 1]]) / 2
        samples.append([*rotvec, *moved[:3, 3]])
    found = np.cov(np.array(samples).T)
    np.testing.assert_allclose(found[:5, :5], spread[:5, :5], atol=1.5e-5)  # sampling: 2.2 % of variances of up to 2e-4
    np.testing.assert_allclose(np.sqrt(spread[3, 3]), 0.01, rtol=0.01)


def test_error_bars_are_wider_with_a_calibration_error() -> None:
    rng = np.random.default_rng(0)
    box = random_box(rng, WELL_SEEN)
    scan = scan_of(box, view=random_view(rng, box, WELL_SEEN), rng=rng)
    perfect, real = measure(scan, camera=CAMERA).boxes[0], measure(scan, camera=sensor("pico_flexx")).boxes[0]
    np.testing.assert_allclose(real.dimensions, perfect.dimensions, rtol=1e-12)
    assert np.all(np.array(real.sigma) > np.array(perfect.sigma))
    assert real.volume_sigma > perfect.volume_sigma


@pytest.mark.parametrize("seed", range(3))
def test_noise_that_is_alike_in_neighbours_widens_the_bars(seed: int) -> None:
    """The same spread of the noise, once white and once smooth over some ten pixels: only a block mean shows the difference."""
    rng = np.random.default_rng(seed)
    box = random_box(rng, WELL_SEEN)
    clean = scan_of(box, view=random_view(rng, box, WELL_SEEN))
    image = clean.organised()
    white = rng.standard_normal(image.shape[:2])
    smooth = np.kron(rng.standard_normal((18, 23)), np.ones((10, 10)))[: image.shape[0], : image.shape[1]]
    found = [
        measure(Scan.from_array(image * (1 + 0.004 * noise[..., None]), intrinsics=clean.intrinsics), camera=CAMERA).boxes[0]
        for noise in (white, smooth)
    ]
    assert found[0].knowledge.inflation < 1.5
    assert found[1].knowledge.inflation > 4
    assert found[1].volume_sigma > 1.5 * found[0].volume_sigma


@given(value=st.floats(0.02, 1.5), sharpness=st.floats(0.0, 9.0))
def test_the_interval_of_a_profile_holds_its_peak_however_sharp_that_is(value: float, sharpness: float) -> None:
    """A peak far narrower than the grid leaves a grid step's width, never nothing and never a number that is none."""
    nodes = np.sort([*np.geomspace(0.01, 3.0, 12), value])
    found = interval_of_profile(value, nodes, -(10**sharpness) * np.log(nodes / value) ** 2)
    assert 0 < found.low <= value <= found.high
    if sharpness > 5:
        assert found.high / found.low < 1.35
        assert 0 < found.sigma < 0.15 * value


def test_few_pixels_say_that_a_cut_box_is_bounded_only_where_all_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Boxes that leave the image: what is answered by few pixels first is what is answered by all."""
    falls: list[tuple[float, float]] = []

    def asked_both_ways(axis: int, fit: Fit, known: Knowledge) -> bool:
        value = float(fit.box.extents[axis])
        few, every = (fall(each, axis, 1.2 * value, SHARP[0]) for each in (of_few_pixels(fit, SHARP[0]), fit))
        falls.append((few, every))
        return answered(axis, fit, known)

    answered = _uncertainty._is_flat_beyond
    monkeypatch.setattr(_uncertainty, "_is_flat_beyond", asked_both_ways)
    for number in range(4):
        case = volume_case(VolumeSettings(seed=31, side=(0.5, 1.2)), number)
        for view in np.flatnonzero(case.reachable).tolist():
            scan = case.scans.scan(view, 0)
            if scan is not None:
                measure(scan, camera=case.camera)
    few, every = np.array(falls).T
    surely = few >= CLEARLY * LEVEL
    assert len(falls) > 6
    assert surely.mean() > 0.5, "else asking few first costs time and saves none"
    assert np.all(every[surely] >= LEVEL)

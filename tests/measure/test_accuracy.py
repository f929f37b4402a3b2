"""Measured boxes against the truth: without noise, with it, with a miscalibrated camera, one box and several, from anywhere."""

from itertools import pairwise

import numpy as np
import pytest

from tests.oracles.scenes import (
    CAMERA,
    WELL_SEEN,
    aligned_extents,
    corner_view,
    holds,
    in_world,
    miscalibrated,
    relative_volume_error,
    scan_of,
)
from viewgain.box import Box, entry_mask
from viewgain.camera import sensor
from viewgain.geometry import inverse
from viewgain.measure import LOOSE_PRIOR, BoxEstimate, measure
from viewgain.scans import Scan
from viewgain.scenes import orbit_pose, random_box, random_view, standing_box


def only_box(scan: Scan, **settings: object) -> BoxEstimate:
    measured = measure(scan, **{"camera": CAMERA, **settings})
    assert measured.reason is None
    assert len(measured.boxes) == 1
    return measured.boxes[0]


@pytest.mark.slow
def test_without_noise_a_box_showing_three_faces_is_measured_to_a_millimetre() -> None:
    """A millimetre is a fifth of a pixel here. What is left is where in its pixel an edge lies, which evens out along the edge.

    So nine out of ten scenes are within a millimetre in all dimensions; an edge along a row of pixels may be half a pixel off.
    """
    rng, errors = np.random.default_rng(0), []
    for _ in range(24):
        box = standing_box(rng.uniform(0.15, 0.5, 3), yaw=rng.uniform(0, 6))
        azimuth, elevation, distance, roll = rng.uniform([30, 30, 0.9, -40], [60, 50, 1.4, 40])
        view = corner_view(box, azimuth_deg=azimuth, elevation_deg=elevation, distance=distance, roll_deg=roll)
        found = only_box(scan_of(box, view=view))
        if found.quality.cut or any(face.incidence > np.deg2rad(72) for face in found.quality.faces):
            continue  # grazing faces: centimetres off where a perfect camera, unlike any real one, still sees them
        assert found.quality.faces_seen == 3
        errors.append(np.abs(found.dimensions - np.sort(box.extents)[::-1]).max())
    assert len(errors) >= 12
    assert np.median(errors) < 0.5e-3
    assert np.quantile(errors, 0.9) < 1e-3
    assert np.max(errors) < 3e-3


@pytest.mark.parametrize("seed", range(8))
def test_the_measured_box_lies_where_the_box_is(seed: int) -> None:
    """Every true corner is at a measured corner, in the world of the scan's pose, to 3 mm: noise-free, at 1.1 m."""
    rng = np.random.default_rng(seed)
    box = standing_box(np.array([0.4, 0.3, 0.2]), yaw=rng.uniform(0, 6), at=(0.1, -0.2))
    view = corner_view(box, azimuth_deg=rng.uniform(35, 55), elevation_deg=rng.uniform(30, 50), distance=1.1, roll_deg=5)
    found = only_box(scan_of(box, view=view))
    apart = np.linalg.norm(in_world(found, view).corners()[:, None] - box.corners()[None], axis=-1)
    assert apart.min(axis=0).max() < 3e-3
    assert len(set(apart.argmin(axis=0))) == 8


@pytest.fixture(scope="module")
def noisy() -> list[tuple[BoxEstimate, Box]]:
    """30 measured scenes with the camera's noise and perfect calibration, and the truth of each."""
    rng, results = np.random.default_rng(11), []
    for _ in range(30):
        box = random_box(rng, WELL_SEEN)
        results.append((only_box(scan_of(box, view=random_view(rng, box, WELL_SEEN), rng=rng)), box))
    return results


@pytest.mark.slow
def test_with_noise_the_intervals_hold_the_truth_about_as_often_as_they_say(noisy: list[tuple[BoxEstimate, Box]]) -> None:
    """At 90 %, three standard errors below: 0.80 for 30 x 3 dimensions, 0.73 for 30 volumes."""
    held = [holds(e, t) for found, box in noisy for e, t in zip(found.interval90, np.sort(box.extents)[::-1], strict=True)]
    assert np.mean(held) > 0.80
    assert np.mean([holds(found.volume_interval90, box.volume) for found, box in noisy]) > 0.73


@pytest.mark.slow
def test_with_noise_the_volume_is_good_to_a_per_cent(noisy: list[tuple[BoxEstimate, Box]]) -> None:
    errors = [abs(relative_volume_error(found, box)) for found, box in noisy]
    assert np.median(errors) < 0.008
    assert np.quantile(errors, 0.9) < 0.03


@pytest.mark.slow
def test_the_intervals_are_not_wider_than_they_need_be(noisy: list[tuple[BoxEstimate, Box]]) -> None:
    """Errors over sigma have a spread of about one: below 0.6 the bars would be twice what the scan deserves."""
    z = [(d - t) / s for found, box in noisy
         for d, t, s in zip(found.dimensions, np.sort(box.extents)[::-1], found.sigma, strict=True)]  # fmt: skip
    assert 0.6 < np.sqrt(np.mean(np.clip(z, -4, 4) ** 2)) < 1.6


@pytest.mark.slow
def test_a_miscalibrated_camera_stays_within_its_systematic_error() -> None:
    """The camera's own scale and offset error, drawn anew for each of 24 scenes: it knows how wrong it may be."""
    camera, rng, held = sensor("pico_flexx"), np.random.default_rng(13), []
    for _ in range(24):
        box = random_box(rng, WELL_SEEN)
        scan = scan_of(box, view=random_view(rng, box, WELL_SEEN), camera=camera, rng=rng)
        wrong = miscalibrated(scan, scale=rng.normal(0, camera.scale_sd), offset=rng.normal(0, camera.offset_sd))
        found = only_box(wrong, camera=camera)
        held.append(holds(found.volume_interval90, box.volume))
    assert np.mean(held) > 0.71


@pytest.mark.parametrize(("scale", "offset"), [(0.004, 0.0), (-0.004, 0.0), (0.0, 0.004), (0.0, -0.004)])
def test_a_calibration_error_shifts_the_answer_as_the_error_bars_assume(scale: float, offset: float) -> None:
    """First order: extents move by L^-1 S (scale, offset), here 0.3 to 1.8 mm; the rest of the way is pixels changing sides."""
    rng, misses = np.random.default_rng(14), []
    for _ in range(4):
        box = random_box(rng, WELL_SEEN)
        scan = scan_of(box, view=random_view(rng, box, WELL_SEEN))
        straight, wrong = only_box(scan), only_box(miscalibrated(scan, scale=scale, offset=offset))
        known = straight.knowledge
        expected = (np.linalg.inv(known.information + LOOSE_PRIOR) @ known.systematic[:, :2] @ (scale, offset))[6:]
        assert np.all(np.abs(expected) > 1e-4)
        misses += list(aligned_extents(straight.box, wrong.box) - straight.box.extents - expected)
    assert np.median(np.abs(misses)) < 1e-4
    assert np.max(np.abs(misses)) < 8e-4


def two_boxes(rng: np.random.Generator) -> tuple[Box, Box]:
    first = standing_box(rng.uniform(0.15, 0.32, 3), yaw=rng.uniform(0, 1.5), at=(-0.28, 0.0))
    return first, standing_box(rng.uniform(0.15, 0.32, 3), yaw=rng.uniform(0, 1.5), at=(0.28, 0.1))


@pytest.mark.parametrize("seed", range(6))
def test_two_boxes_apart_are_both_measured_the_larger_in_the_image_first(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = two_boxes(rng)
    view = orbit_pose(np.array([0.0, 0.0, 0.1]), rng.uniform(-2.2, -0.9), np.deg2rad(rng.uniform(32, 50)), 1.4)
    measured = measure(scan_of(*boxes, view=view, rng=rng), camera=CAMERA)
    assert len(measured.boxes) == 2
    for box in boxes:
        nearest = min(measured.boxes, key=lambda found: np.linalg.norm(in_world(found, view).centre - box.centre))
        assert np.linalg.norm(in_world(nearest, view).centre - box.centre) < 0.01
        slack = [max(5 * s, 0.003) for s in nearest.sigma]
        assert np.all(np.abs(nearest.dimensions - np.sort(box.extents)[::-1]) < slack)
        assert "touching" not in nearest.flags
    assert all(first.quality.returns >= second.quality.returns for first, second in pairwise(measured.boxes))


def test_a_box_half_hidden_by_another_is_still_measured() -> None:
    """The front box hides a lower corner of the one behind; what it hides is not taken for the end of the box."""
    front, back = (
        standing_box(np.array([0.2, 0.2, 0.15]), at=(0.3, 0.1)),
        standing_box(np.array([0.3, 0.4, 0.35]), at=(-0.15, 0.0)),
    )
    view = orbit_pose(np.array([0.0, 0.0, 0.1]), 0.5, np.deg2rad(35), 1.4)
    measured = measure(scan_of(front, back, view=view, rng=np.random.default_rng(3)), camera=CAMERA)
    behind = min(measured.boxes, key=lambda found: np.linalg.norm(in_world(found, view).centre - back.centre))
    np.testing.assert_allclose(behind.dimensions, [0.4, 0.35, 0.3], atol=0.01)


@pytest.mark.parametrize("elevation_deg", [90.0, 86.0])
@pytest.mark.parametrize("with_floor_scan", [False, True])
def test_from_overhead_a_box_is_measured_with_and_without_an_empty_scan(elevation_deg: float, with_floor_scan: bool) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        box = standing_box(rng.uniform(0.15, 0.4, 3), yaw=rng.uniform(0, 1.5))
        view = orbit_pose(np.array([0.02, 0.01, box.extents[2]]), rng.uniform(0, 6), np.deg2rad(elevation_deg), 1.0)
        floor = scan_of(view=view, rng=rng) if with_floor_scan else None
        found = only_box(scan_of(box, view=view, rng=rng), floor=floor)
        np.testing.assert_allclose(found.dimensions, np.sort(box.extents)[::-1], atol=0.004)
        assert abs(relative_volume_error(found, box)) < 5 * found.volume_sigma / found.volume


@pytest.mark.parametrize("seed", range(4))
def test_an_empty_scan_stands_in_for_a_floor_that_the_scan_itself_does_not_show(seed: int) -> None:
    """A black floor: nothing comes back beside the box, and an empty scan (of the same floor, whitened) was taken before."""
    rng = np.random.default_rng(seed)
    box = standing_box(rng.uniform(0.2, 0.4, 3))
    view = corner_view(box, azimuth_deg=rng.uniform(20, 70), elevation_deg=rng.uniform(30, 55), distance=1.1)
    full, empty = scan_of(box, view=view, rng=rng), scan_of(view=view, rng=rng)
    image = full.organised()
    hit = entry_mask(box.in_frame(inverse(view)), CAMERA.intrinsics.directions().reshape(-1, 3))
    image[~hit.reshape(image.shape[:2])] = np.nan
    found = only_box(Scan.from_array(image, intrinsics=full.intrinsics), floor=empty)
    np.testing.assert_allclose(found.dimensions[found.vertical], box.extents[2], atol=0.008)


def test_the_floor_is_taken_from_the_empty_scan_where_one_is_given() -> None:
    rng, box = np.random.default_rng(5), standing_box(np.array([0.35, 0.25, 0.3]))
    view = corner_view(box, elevation_deg=50)
    scan, empty = scan_of(box, view=view, rng=rng), scan_of(view=view, rng=rng)
    measured = measure(scan, camera=CAMERA, floor=empty)
    alone = measure(empty, camera=CAMERA)
    assert measured.floor is not None
    assert alone.floor is not None
    np.testing.assert_array_equal(measured.floor.plane.normal, alone.floor.plane.normal)
    assert measured.floor.plane.offset == alone.floor.plane.offset


def test_without_a_camera_the_noise_is_estimated_and_the_default_calibration_assumed() -> None:
    rng, box = np.random.default_rng(6), standing_box(np.array([0.35, 0.25, 0.3]))
    for noise in (0.002, 0.01):
        camera = sensor("pico_flexx")
        scan = scan_of(
            box,
            view=corner_view(box),
            camera=type(camera)(name="x", intrinsics=camera.intrinsics, noise_per_metre=noise),
            rng=rng,
        )
        found = only_box(scan, camera=None)
        np.testing.assert_allclose(
            found.views[0].noise * camera.noise_per_metre, noise, rtol=0.25
        )  # the lateral noise is the same in both
        assert (found.views[0].sensor.scale_sd, found.views[0].sensor.offset_sd) == (0.003, 0.003)
        np.testing.assert_allclose(found.dimensions, [0.35, 0.3, 0.25], atol=0.005)

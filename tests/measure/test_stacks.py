"""Several boxes that touch or stand on each other: each measured, or given a reason."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.stacks import carton_scene, matched
from tests.oracles import shapes
from tests.oracles.scenes import CAMERA, scan_of
from viewgain.box import Box
from viewgain.geometry import rotation_from_rotvec
from viewgain.measure import BoxEstimate, measure
from viewgain.measure._grouping import groups
from viewgain.measure._patches import Facing, Patch
from viewgain.measure._stack import loosened
from viewgain.measure._steps import seam_height
from viewgain.measure._support import shared_room
from viewgain.scans import Scan
from viewgain.scenes import orbit_pose, random_box, random_view, standing_box

LOWER, UPPER = np.array([0.3, 0.25, 0.15]), np.array([0.2, 0.16, 0.2])


def stack() -> tuple[Box, Box]:
    """A small box on a larger one, turned by 10 degrees."""
    upper = standing_box(UPPER, yaw=0.17)
    raised = upper.box_to_camera.copy()
    raised[2, 3] = LOWER[2]
    return standing_box(LOWER), Box(raised, UPPER)


def stack_scan(seed: int, azimuth: float = 0.8) -> Scan:
    view = orbit_pose(np.array([0.0, 0.0, 0.17]), azimuth, np.deg2rad(38), 1.1)
    return scan_of(*stack(), view=view, rng=np.random.default_rng(seed))


def by_height(boxes: tuple[BoxEstimate, ...], scan: Scan) -> list[BoxEstimate]:
    assert scan.camera_to_world is not None
    return sorted(boxes, key=lambda box: float((scan.camera_to_world[:3, :3] @ box.box.centre)[2]))


@pytest.mark.parametrize("seed", range(3))
def test_of_a_stack_of_two_both_are_measured_and_the_upper_from_its_support(seed: int) -> None:
    scan = stack_scan(seed)
    found = measure(scan, camera=CAMERA)
    assert len(found.boxes) == 2
    lower, upper = by_height(found.boxes, scan)
    np.testing.assert_allclose(lower.dimensions, np.sort(LOWER)[::-1], atol=0.02)
    np.testing.assert_allclose(upper.dimensions, np.sort(UPPER)[::-1], atol=0.02)
    np.testing.assert_allclose(upper.box.extents[2], UPPER[2], atol=0.012)
    assert "stacked" in upper.flags
    assert "stacked" not in lower.flags
    assert all("touching" in box.flags for box in (lower, upper))


def test_of_a_touching_row_of_unlike_heights_both_are_measured() -> None:
    tall, low = (
        standing_box(np.array([0.2, 0.2, 0.3]), at=(-0.1, 0.0)),
        standing_box(np.array([0.25, 0.2, 0.15]), at=(0.125, 0.03)),
    )
    scan = scan_of(tall, low, view=orbit_pose(np.array([0, 0, 0.12]), 0.7, np.deg2rad(38), 1.2), rng=np.random.default_rng(3))
    found = measure(scan, camera=CAMERA).boxes
    assert len(found) == 2
    volumes = sorted(box.volume for box in found)
    np.testing.assert_allclose(volumes, sorted((tall.volume, low.volume)), rtol=0.12)
    assert not any("stacked" in box.flags for box in found)


def test_the_order_of_the_points_does_not_matter_to_a_stack() -> None:
    scan = stack_scan(0)
    order = np.random.default_rng(1).permutation(len(scan.points))
    assert scan.pixels is not None
    image = np.full((scan.shape[0] * scan.shape[1], 3), np.nan)  # type: ignore[index]
    image[scan.pixels[order]] = scan.points[order]
    shuffled = Scan.from_array(image.reshape(*scan.shape, 3), intrinsics=scan.intrinsics)  # type: ignore[misc]
    straight = measure(scan, camera=CAMERA).boxes
    again = measure(shuffled, camera=CAMERA).boxes
    assert [box.flags for box in straight] == [box.flags for box in again]
    for one, other in zip(straight, again, strict=True):
        np.testing.assert_allclose(one.dimensions, other.dimensions, atol=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_a_box_alone_is_never_split(seed: int) -> None:
    rng = np.random.default_rng(2000 + seed)
    box = random_box(rng)
    found = measure(scan_of(box, view=random_view(rng, box), rng=rng), camera=CAMERA)
    assert len(found.boxes) == 1
    assert not {"stacked", "touching"} & set(found.boxes[0].flags)


@pytest.mark.parametrize("name", ["learn1", "learn14", "learn17", "learn20"])
def test_real_cartons_that_touch_or_are_stacked_are_all_found(data_dir: Path, name: str) -> None:
    scan, labels = carton_scene(data_dir / f"real_boxes/mosd_boxes/{name}.npz")
    found, false = matched(measure(scan), scan, labels)
    assert all(one.box is not None for one in found)
    assert false == 0
    assert any("stacked" in one.box.flags for one in found if one.box is not None) == (name in {"learn17", "learn20"})


def patch(
    low: tuple[float, float, float], high: tuple[float, float, float], normal: tuple[float, float, float], start: int
) -> Patch:
    """A flat patch of 400 points that fills a rectangle given by two opposite corners."""
    axes = [np.linspace(a, b, 20 if a != b else 1) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    facing = Facing.LYING if normal[2] == 1 else Facing.UPRIGHT
    return Patch(np.arange(start, start + len(points)), points, np.array(normal), float(np.dot(normal, low)), facing)


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.0, 4.0])
def test_a_flush_front_of_a_stack_is_shared_by_both_boxes_however_the_scene_is_turned(turn: float) -> None:
    """One front, two tops: of the front's points those above the lower top belong to the upper box."""
    front = patch((0.1, -0.1, 0.0), (0.1, 0.1, 0.3), (1, 0, 0), 0)
    lower, upper = (
        patch((-0.3, -0.1, 0.15), (0.1, 0.1, 0.15), (0, 0, 1), 400),
        patch((-0.1, -0.1, 0.3), (0.1, 0.1, 0.3), (0, 0, 1), 800),
    )
    spin = rotation_from_rotvec(np.array([0, 0, turn]))
    turned = [Patch(p.pixels, p.points @ spin.T, spin @ p.normal, p.offset, p.facing) for p in (front, lower, upper)]
    ranges = type("Seen", (), {"ranges": np.full((30, 40), 1.0)})()
    made = groups(turned, ranges, 0.001)
    assert [len(group.pixels) for group in made] == [400 + 220, 400 + 180]
    assert made[0].top < 0.17
    assert made[1].bottom > 0.15


def bowed(radius: float) -> Patch:
    """An upright patch 12 cm wide and high with 1 mm noise, bent about the vertical to a radius."""
    rng = np.random.default_rng(0)
    y, z = rng.uniform(-0.06, 0.06, (2, 800))
    x = np.sqrt(radius**2 - y**2) - radius + rng.normal(0, 0.001, 800)
    return Patch(np.arange(800), np.column_stack([x - x.mean(), y, z]), np.array([1.0, 0, 0]), 0.0, Facing.UPRIGHT)


@pytest.mark.parametrize(("radius", "curved"), [(0.1, True), (0.25, True), (0.8, False), (5.0, False)])
def test_a_can_is_curved_and_a_bulging_carton_is_not(radius: float, curved: bool) -> None:
    assert bowed(radius).is_curved() == curved


@pytest.mark.parametrize("shape", [shapes.sphere(0.2), shapes.sphere(0.12)])
@pytest.mark.parametrize("seed", range(3))
def test_balls_are_no_boxes_however_they_are_split(shape: shapes.Shape, seed: int) -> None:
    view = orbit_pose(np.array([0.0, 0.0, 0.12]), 0.3 + seed, np.deg2rad(38), 1.1)
    found = measure(shapes.scan_of(shape, view, CAMERA, rng=np.random.default_rng(seed)), camera=CAMERA)
    assert (found.boxes, found.reason) == ((), "not_a_box")


@pytest.mark.parametrize(("step", "seam"), [(0.0, False), (0.001, False), (0.01, True), (-0.01, False)])
def test_a_seam_is_where_the_side_steps_outwards(step: float, seam: bool) -> None:
    rng = np.random.default_rng(1)
    y, z = rng.uniform([[-0.1], [0.0]], [[0.1], [0.3]], (2, 1200))
    x = np.where(z < 0.12, step, 0.0) + rng.normal(0, 0.003, 1200)
    found = seam_height([Patch(np.arange(1200), np.column_stack([x, y, z]), np.array([1.0, 0, 0]), 0.0, Facing.UPRIGHT)])
    assert (found is not None) == seam
    if found is not None:
        assert found == pytest.approx(0.12, abs=0.02)


def test_a_box_shares_all_its_room_with_itself_and_half_with_one_half_a_side_off() -> None:
    box, off = standing_box(np.array([0.2, 0.3, 0.1])), standing_box(np.array([0.2, 0.3, 0.1]), at=(0.1, 0.0))
    assert (shared_room(box, box), shared_room(box, off)) == (1.0, 0.5)


def test_a_touching_box_has_wider_intervals_in_the_plane_than_in_height() -> None:
    alone = measure(scan_of(standing_box(LOWER), view=orbit_pose(np.zeros(3), 0.8, 0.6, 1.1)), camera=CAMERA).boxes[0]
    loose = loosened(alone)
    grown = [(b.high - b.low) / (a.high - a.low) for a, b in zip(alone.intervals, loose.intervals, strict=True)]
    assert min(grown) > 1
    assert [b.sigma for b in loose.intervals] == pytest.approx(np.sqrt(np.diag(loose.covariance)[6:]))

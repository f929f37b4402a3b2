"""What the user is warned of: cut, open, grazing, bent, few points, touching."""

import numpy as np
import pytest

from tests.oracles.scenes import CAMERA, aligned_extents, corner_view, holds, in_world, scan_of
from viewgain.box import Box, box_hits, entry_mask
from viewgain.evaluation import VolumeSettings, volume_case
from viewgain.geometry import inverse
from viewgain.measure import BoxEstimate, measure
from viewgain.scans import Scan
from viewgain.scenes import orbit_pose, standing_box


def middling() -> Box:
    return standing_box(np.array([0.35, 0.25, 0.3]))


def found_in(scan: Scan) -> BoxEstimate:
    measured = measure(scan, camera=CAMERA)
    assert len(measured.boxes) == 1, measured.reason
    return measured.boxes[0]


def pointed_aside(box: Box, sideways: float, *, distance: float = 1.1) -> np.ndarray:
    """A camera that looks past the box by so many metres to its left; half the image is 0.66 m wide there."""
    view = corner_view(box, elevation_deg=38, distance=distance)
    return orbit_pose(box.centre + sideways * view[:3, 0], np.deg2rad(45), np.deg2rad(38), distance)


def test_a_box_well_inside_the_image_has_no_flag() -> None:
    assert found_in(scan_of(middling(), view=corner_view(middling()), rng=np.random.default_rng(0))).flags == ()


@pytest.mark.parametrize("sideways", [-0.65, -0.6, -0.55, 0.55, 0.6, 0.65])
def test_a_box_cut_by_the_side_of_the_image_is_flagged_cut(sideways: float) -> None:
    box = middling()
    view = pointed_aside(box, sideways)
    corners = box.in_frame(inverse(view)).corners()
    u = CAMERA.intrinsics.project(corners)[:, 0]
    assert u.min() < -2 or u.max() > 226, "the scene is as meant"
    found = found_in(scan_of(box, view=view, rng=np.random.default_rng(1)))
    assert "cut" in found.flags


@pytest.mark.parametrize("sideways", [-0.35, -0.2, 0.0, 0.2, 0.35])
def test_a_box_beside_the_middle_but_inside_is_not_cut(sideways: float) -> None:
    found = found_in(scan_of(middling(), view=pointed_aside(middling(), sideways), rng=np.random.default_rng(1)))
    assert "cut" not in found.flags
    np.testing.assert_allclose(found.dimensions, [0.35, 0.3, 0.25], atol=0.006)


@pytest.mark.slow
def test_of_a_cut_box_no_more_is_claimed_than_is_seen() -> None:
    """An open dimension's interval misses the truth one time in ten; a closed one is right to five sigma, or to 1 cm.

    Of a box that shows little more than one corner the yaw may come out wrong, and all with it: one box in ten may.
    """
    rng, held, wrong, boxes = np.random.default_rng(0), [], 0, 0
    for _ in range(20):
        box = standing_box(rng.uniform(0.25, 0.45, 3), yaw=rng.uniform(0, 1.5))
        view = pointed_aside(box, float(rng.choice([-1, 1]) * rng.uniform(0.5, 0.7)))
        for found in measure(scan_of(box, view=view, rng=rng), camera=CAMERA).boxes:
            truth = aligned_extents(in_world(found, view), box)
            off = np.abs(found.box.extents - truth)
            closed = [axis for axis in range(3) if not found.is_open[axis]]
            wrong += any(off[axis] > max(5 * found.intervals[axis].sigma, 0.01) for axis in closed)
            boxes += 1
            held += [found.intervals[axis].low <= truth[axis] <= found.intervals[axis].high for axis in {0, 1, 2} - set(closed)]
    assert boxes >= 10
    assert wrong <= boxes / 10
    assert len(held) >= 4
    assert np.mean(held) >= 0.7


@pytest.mark.parametrize(("number", "station"), [(9, 1), (12, 1), (13, 3), (19, 0)])
def test_a_cut_box_with_all_its_ends_in_view_is_bounded(number: int, station: int) -> None:
    """Steps of pixels beside the likelihood's peak, some of them higher, leave nothing open: boxes for which they once did."""
    case = volume_case(VolumeSettings(seed=92), number)
    scan = case.scans.scan(station, 0)
    assert scan is not None
    found = measure(scan, camera=case.camera).boxes[0]
    assert "cut" in found.flags
    assert "open" not in found.flags
    assert found.volume == pytest.approx(case.box.volume, rel=0.03)


@pytest.mark.parametrize("seed", range(4))
def test_a_top_whose_far_end_leaves_the_image_is_open_there_and_no_shorter_than_seen(seed: int) -> None:
    """The top alone, its end beyond the left border: its length is open, the rest is not."""
    box = standing_box(np.array([0.9, 0.3, 0.25]))
    view = orbit_pose(np.array([0.45, 0.0, 0.25]), np.deg2rad(-90.0), np.deg2rad(80.0), 0.9)
    found = found_in(scan_of(box, view=view, rng=np.random.default_rng(seed)))
    long = int(np.argmax(np.abs(in_world(found, view).box_to_camera[0, :3])))
    interval = found.intervals[long]
    assert "open" in found.flags
    assert np.isinf(interval.high)
    assert 0.45 < interval.low <= 0.9
    others = [axis for axis in range(3) if axis != long]
    np.testing.assert_allclose(np.sort(found.box.extents[others]), [0.25, 0.3], atol=0.01)
    assert all(np.isfinite(found.intervals[axis].high) for axis in others), "the height is known from the top and the floor"


@pytest.mark.parametrize("seed", range(8))
def test_a_front_that_hides_its_depth_is_open_with_a_lower_bound(seed: int) -> None:
    """The camera below the top's level and square to the front: nothing shows the depth, and nothing is claimed of it."""
    rng = np.random.default_rng(seed)
    box = standing_box(rng.uniform([0.2, 0.25, 0.25], [0.4, 0.4, 0.35]))
    eye = np.array([box.extents[0] / 2 + 1.0, rng.normal(0, 0.005), box.extents[2] * rng.uniform(0.7, 0.95)])
    view = orbit_pose(box.centre, *_towards(eye - box.centre))
    found = found_in(scan_of(box, view=view, rng=rng))
    hidden = int(np.argmax(np.abs(in_world(found, view).box_to_camera[0, :3])))
    assert "open" in found.flags
    assert found.is_open[hidden]
    place = int(np.flatnonzero(found.order == hidden)[0])
    assert found.interval90[place][1] is None
    assert found.interval90[place][0] <= box.extents[0]
    assert found.sigma[place] is None
    assert found.basis[place] == "open"
    assert found.volume_sigma is None
    assert found.volume_interval90[1] is None
    assert found.volume_interval90[0] <= box.volume
    written = found.to_dict(np.eye(4))
    assert written["sigma_m"][place] is None
    assert written["interval90_m"][place][1] is None
    assert written["volume_sigma_m3"] is None
    assert written["volume_interval90_m3"][1] is None
    others = [axis for axis in range(3) if axis != hidden]
    np.testing.assert_allclose(found.box.extents[others], aligned_extents(in_world(found, view), box)[others], atol=0.008)


def _towards(offset: np.ndarray) -> tuple[float, float, float]:
    distance = float(np.linalg.norm(offset))
    return float(np.arctan2(offset[1], offset[0])), float(np.arcsin(offset[2] / distance)), distance


@pytest.mark.slow
def test_a_front_with_a_sliver_of_a_top_claims_no_depth_that_it_does_not_have() -> None:
    """The camera 2 to 15 cm above the top's level, square to the front: the top is a few rows of mixed pixels.

    The depth is open, or its interval holds the truth nine times out of ten; four out of five is asked for here.
    """
    rng, right = np.random.default_rng(0), []
    for _ in range(16):
        box = standing_box(rng.uniform([0.2, 0.2, 0.15], [0.5, 0.5, 0.4]))
        view = orbit_pose(box.centre, *np.deg2rad(rng.uniform([-4, 7], [4, 14])), rng.uniform(0.9, 1.3))
        measured = measure(scan_of(box, view=view, rng=rng), camera=CAMERA)
        for found in measured.boxes:
            hidden = int(np.argmax(np.abs(in_world(found, view).box_to_camera[0, :3])))
            interval = found.intervals[hidden]
            right.append(interval.low <= box.extents[0] <= interval.high)
    assert np.mean(right) > 0.8


@pytest.mark.parametrize(("elevation_deg", "grazing"), [(8.0, True), (30.0, False)])
def test_a_face_seen_flat_is_flagged_grazing(elevation_deg: float, grazing: bool) -> None:
    box = standing_box(np.array([0.35, 0.25, 0.25]))
    found = found_in(scan_of(box, view=corner_view(box, elevation_deg=elevation_deg), rng=np.random.default_rng(2)))
    assert ("grazing" in found.flags) == grazing
    steepest = max(face.incidence for face in found.quality.faces)
    assert grazing == (steepest > np.deg2rad(72))


@pytest.mark.parametrize("depth", [0.012, -0.012])
def test_a_bulging_face_is_flagged_bent_with_the_sign_of_its_bulge(depth: float) -> None:
    """A paraboloid of 12 mm on one face: outwards brings the returns nearer, and counts positive."""
    box, rng = standing_box(np.array([0.4, 0.4, 0.35])), np.random.default_rng(3)
    view = corner_view(box, azimuth_deg=35, elevation_deg=30)
    scan = scan_of(box, view=view, rng=rng)
    seen, rays = box.in_frame(inverse(view)), CAMERA.intrinsics.directions().reshape(-1, 3)
    hits = box_hits(seen, rays)
    local = (rays * np.minimum(hits.ranges, 9)[:, None] - seen.box_to_camera[:3, 3]) @ seen.box_to_camera[:3, :3]
    front = entry_mask(seen, rays) & (hits.planes == 0)
    bowl = 1 - (local[:, 1] / 0.2) ** 2 / 2 - ((local[:, 2] - 0.175) / 0.175) ** 2 / 2
    shift = np.where(front, -depth * bowl / np.maximum(hits.cosine, 0.2), 0.0).reshape(171, 224)
    image = scan.organised()
    distance = np.linalg.norm(image, axis=-1)
    bulged = Scan.from_array(image * ((distance + shift) / distance)[..., None], intrinsics=scan.intrinsics)
    found = found_in(bulged)
    assert "bent" in found.flags
    front_normal = seen.box_to_camera[:3, 0]
    normals = {"+x": (0, 1), "-x": (0, -1), "+y": (1, 1), "-y": (1, -1), "top": (2, 1)}

    def facing(name: str) -> float:
        axis, sign = normals[name]
        return float(sign * found.box.box_to_camera[:3, axis] @ front_normal)

    bend = max(found.quality.faces, key=lambda face: facing(face.name)).bend
    assert np.sign(bend) == np.sign(depth)
    assert 0.004 < abs(bend) < 0.03
    flat = found_in(scan)
    assert "bent" not in flat.flags


def test_a_small_box_far_away_has_few_points() -> None:
    box = standing_box(np.array([0.1, 0.08, 0.08]))
    found = found_in(scan_of(box, view=corner_view(box, distance=1.5, elevation_deg=45), rng=np.random.default_rng(4)))
    assert found.quality.returns < 300
    assert "few_points" in found.flags
    near = found_in(scan_of(box, view=corner_view(box, distance=0.6, elevation_deg=45), rng=np.random.default_rng(4)))
    assert "few_points" not in near.flags


def test_returns_are_those_on_the_box() -> None:
    """Counted against the truth: pixels that look at the box and came back, less a rim of one pixel and 4-sigma outliers."""
    box = middling()
    view = corner_view(box)
    scan = scan_of(box, view=view, rng=np.random.default_rng(5))
    hit = entry_mask(box.in_frame(inverse(view)), CAMERA.intrinsics.directions().reshape(-1, 3))
    true = np.count_nonzero(hit[scan.pixels])
    found = found_in(scan)
    assert 0.9 * true < found.quality.returns <= 1.01 * true
    assert sum(face.returns for face in found.quality.faces) == pytest.approx(found.quality.returns, abs=3)
    assert found.quality.faces_seen == 3
    assert found.quality.explained > 0.98
    assert found.quality.overlap > 0.95


@pytest.mark.slow
def test_two_boxes_side_by_side_are_split_or_refused_or_flagged_more_often_than_not() -> None:
    """Measured rate: of 16 pairs of unlike height that touch, at least half do not pass for one flawless box.

    A known weakness: a step of 3 cm between two tops is within what one return may be off, so more than a third of them pass.
    """
    rng, honest, pairs = np.random.default_rng(5), 0, 0
    while pairs < 16:
        first, second = rng.uniform(0.15, 0.35, 3), rng.uniform(0.15, 0.35, 3)
        if abs(first[2] - second[2]) < 0.03:
            continue
        pairs += 1
        boxes = standing_box(first, at=(-first[0] / 2, 0.0)), standing_box(second, at=(second[0] / 2, 0.0))
        view = orbit_pose(np.array([0, 0, 0.1]), rng.uniform(-2.2, -0.9), np.deg2rad(rng.uniform(30, 50)), 1.3)
        found = measure(scan_of(*boxes, view=view, rng=rng), camera=CAMERA).boxes
        warned = any({"touching", "bent"} & set(box.flags) for box in found)
        right = all(any(holds(box.volume_interval90, true.volume) for true in boxes) for box in found)
        honest += not found or warned or right
    assert honest >= 8


def two_steps(azimuth_deg: float) -> list[BoxEstimate]:
    """What is measured of a tall box with a low one against it."""
    tall, low = (
        standing_box(np.array([0.25, 0.25, 0.4]), at=(-0.125, 0.0)),
        standing_box(np.array([0.25, 0.25, 0.15]), at=(0.125, 0.0)),
    )
    view = orbit_pose(np.array([0, 0, 0.15]), np.deg2rad(azimuth_deg), np.deg2rad(35), 1.3)
    return list(measure(scan_of(tall, low, view=view, rng=np.random.default_rng(6)), camera=CAMERA).boxes)


def test_two_steps_are_split_and_the_first_is_flagged_touching() -> None:
    tall, low = two_steps(130)
    np.testing.assert_allclose(tall.dimensions, [0.4, 0.25, 0.25], atol=0.015)
    assert "touching" in tall.flags
    assert low.volume < tall.volume


def test_whatever_was_split_off_another_object_is_flagged_touching() -> None:
    found = [box for azimuth_deg in (35, 50, 130) for box in two_steps(azimuth_deg)]
    assert all("touching" in box.flags for box in found)

"""What measuring returns and its JSON form, key by key (schema 1)."""

import json
from dataclasses import replace
from itertools import pairwise, permutations
from typing import Any

import numpy as np
import pytest

from tests.oracles import shapes
from tests.oracles.scenes import CAMERA, aligned_extents, corner_view, in_world, scan_of
from viewgain.box import Box
from viewgain.geometry import inverse, require_rigid, transform
from viewgain.measure import REASONS, SCHEMA, BoxEstimate, Measurement, measure
from viewgain.measure._uncertainty import Interval
from viewgain.scans import Scan
from viewgain.scenes import orbit_pose, standing_box

BOX_KEYS = {
    "dimensions_m", "sigma_m", "interval90_m", "vertical", "volume_m3", "volume_sigma_m3", "volume_interval90_m3",
    "box_to_camera", "box_to_world", "faces_seen", "basis", "incidence_deg", "border_share", "flags",
}  # fmt: skip
ROUNDED = 1e-5
"""Lengths are written to a hundredth of a millimetre or better."""


def crate() -> Any:
    return standing_box(np.array([0.35, 0.25, 0.45]), yaw=0.5, at=(0.2, -0.1))


VIEW = corner_view(crate(), azimuth_deg=40, elevation_deg=35, distance=1.4)


@pytest.fixture(scope="module")
def measured() -> Measurement:
    return measure(scan_of(crate(), view=VIEW, rng=np.random.default_rng(0), source="kitchen.ply"), camera=CAMERA)


@pytest.fixture(scope="module")
def opened() -> Measurement:
    """A front whose depth is hidden."""
    box = standing_box(np.array([0.3, 0.35, 0.3]))
    view = orbit_pose(box.centre, 0.0, np.deg2rad(4), 1.15)
    return measure(scan_of(box, view=view, rng=np.random.default_rng(1)), camera=CAMERA)


@pytest.fixture(scope="module")
def empty() -> Measurement:
    return measure(scan_of(view=VIEW, rng=np.random.default_rng(2)), camera=CAMERA)


@pytest.fixture(scope="module")
def floorless() -> Measurement:
    return measure(Scan.from_array(np.random.default_rng(0).uniform([-1, -1, 0.5], [1, 1, 3], (20_000, 3))))


def only(measurement: Measurement) -> BoxEstimate:
    (box,) = measurement.boxes
    return box


def with_extents(box: BoxEstimate, extents: list[float], low: float | None = None) -> BoxEstimate:
    """The estimate with other extents, one per cent wide intervals, and perhaps a first side open above ``low``."""
    intervals = [Interval(0.98 * extent, 1.02 * extent, 0.01 * extent) for extent in extents]
    if low is not None:
        intervals[0] = Interval(low, np.inf, np.nan)
    return replace(box, box=Box(box.box.box_to_camera, np.array(extents)), intervals=tuple(intervals))


def written(measurement: Measurement) -> dict[str, Any]:
    """The JSON form as another program reads it."""
    return dict(json.loads(json.dumps(measurement.to_dict(), allow_nan=False)))


@pytest.mark.parametrize("name", ["measured", "opened", "empty", "floorless"])
def test_the_json_form_has_its_keys_and_survives_json(name: str, request: pytest.FixtureRequest) -> None:
    content = request.getfixturevalue(name).to_dict()
    assert set(content) == {"schema", "scans", "floor", "boxes", "rejected", "reason"}
    assert content["schema"] == SCHEMA == 1
    assert json.loads(json.dumps(content, allow_nan=False)) == content, "plain Python numbers only, no tuple and no NaN"
    assert all(set(box) == BOX_KEYS for box in content["boxes"])
    assert (content["reason"] is None) == bool(content["boxes"])
    assert content["reason"] is None or content["reason"] in REASONS
    assert (content["floor"] is None) == (name == "floorless")
    if content["floor"]:
        assert set(content["floor"]) == {"normal_camera", "camera_height_m", "spread_m"}


def test_the_json_of_a_box_is_the_box(measured: Measurement) -> None:
    box, content = only(measured), written(measured)["boxes"][0]
    np.testing.assert_allclose(content["dimensions_m"], box.dimensions, atol=ROUNDED)
    np.testing.assert_allclose(content["dimensions_m"], [0.45, 0.35, 0.25], atol=0.006)
    np.testing.assert_allclose(content["sigma_m"], box.sigma, atol=ROUNDED)
    np.testing.assert_allclose(content["interval90_m"], box.interval90, atol=ROUNDED)
    np.testing.assert_allclose(content["volume_m3"], np.prod(box.dimensions), rtol=1e-4)
    np.testing.assert_allclose(content["volume_sigma_m3"], box.volume_sigma, atol=1e-6)
    np.testing.assert_allclose(content["volume_interval90_m3"], box.volume_interval90, atol=1e-6)
    assert content["vertical"] == 0
    assert set(content["faces_seen"]) == {face.name for face in box.quality.faces}
    assert len(content["faces_seen"]) == 3
    assert content["basis"] == ["seen", "seen", "seen"]
    assert content["flags"] == []


def test_the_scan_the_floor_and_the_rest_are_named(measured: Measurement) -> None:
    content = written(measured)
    assert content["scans"] == ["kitchen.ply"]
    np.testing.assert_allclose(content["floor"]["camera_height_m"], VIEW[2, 3], atol=0.003)
    np.testing.assert_allclose(content["floor"]["normal_camera"], inverse(VIEW)[:3, 2], atol=0.003)
    assert 0 < content["floor"]["spread_m"] < 0.02
    assert content["rejected"] == []


def test_dimensions_are_sorted_and_each_interval_holds_its_estimate(measured: Measurement, opened: Measurement) -> None:
    for box in (*measured.boxes, *opened.boxes):
        assert all(first >= second for first, second in pairwise(box.dimensions))
        for value, (low, high) in zip(box.dimensions, box.interval90, strict=True):
            assert 0 < low <= value
            assert high is None or value <= high
        low, high = box.volume_interval90
        assert 0 < low <= box.volume
        assert high is None or box.volume <= high


def test_order_leads_from_box_axes_to_dimensions(measured: Measurement) -> None:
    box = only(measured)
    np.testing.assert_allclose(box.box.extents[box.order], box.dimensions)
    assert box.order[box.vertical] == 2
    np.testing.assert_allclose(box.dimensions[box.vertical], 0.45, atol=0.006)


def test_the_pose_is_rigid_at_the_centre_with_axes_along_the_dimensions(measured: Measurement) -> None:
    """Half the dimensions along the pose's axes lead to the eight corners of the true box, camera and world."""
    content, truth = written(measured)["boxes"][0], crate()
    for key, frame in (("box_to_camera", inverse(VIEW)), ("box_to_world", np.eye(4))):
        pose = np.array(content[key])
        require_rigid(pose, key)
        np.testing.assert_allclose(np.linalg.det(pose[:3, :3]), 1, atol=1e-4)
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners = transform(pose, signs * np.array(content["dimensions_m"]) / 2)
        apart = np.linalg.norm(corners[:, None] - transform(frame, truth.corners())[None], axis=-1)
        assert apart.min(axis=0).max() < 0.008
        assert len(set(apart.argmin(axis=0))) == 8
        np.testing.assert_allclose(pose[:3, 3], transform(frame, truth.centre), atol=0.006)


@pytest.mark.parametrize("extents", list(permutations([0.45, 0.35, 0.25])))
def test_the_pose_is_no_mirror_image_whichever_side_is_the_longest(measured: Measurement, extents: tuple[float, ...]) -> None:
    """Six orders of the sides, three of them odd: the axes follow the dimensions and still make a right hand."""
    box = with_extents(only(measured), list(extents))
    pose = box.oriented()
    np.testing.assert_allclose(np.linalg.det(pose[:3, :3]), 1, atol=1e-9)
    for place, axis in enumerate(box.order):
        np.testing.assert_allclose(abs(pose[:3, place] @ box.box.box_to_camera[:3, axis]), 1, atol=1e-9)
        np.testing.assert_allclose(box.dimensions[place], extents[axis])
    np.testing.assert_allclose(pose[:3, 3], box.box.centre)


def test_the_vertical_axis_of_the_pose_stands_upright_in_the_world(measured: Measurement) -> None:
    content = written(measured)["boxes"][0]
    axis = np.array(content["box_to_world"])[:3, content["vertical"]]
    np.testing.assert_allclose(abs(axis[2]), 1, atol=1e-4)


def test_without_a_pose_the_world_is_the_floor_below_the_camera(measured: Measurement) -> None:
    scan = scan_of(crate(), view=VIEW, rng=np.random.default_rng(0))
    free = measure(Scan.from_array(scan.organised(), intrinsics=scan.intrinsics), camera=CAMERA)
    assert free.camera_to_world is None
    np.testing.assert_allclose(transform(free.world, np.zeros(3)), [0, 0, VIEW[2, 3]], atol=0.004)
    box = only(free)
    in_floor_frame = in_world(box, free.world)
    np.testing.assert_allclose(in_floor_frame.corners()[:4, 2], 0, atol=0.004)
    np.testing.assert_allclose(in_floor_frame.corners()[4:, 2], 0.45, atol=0.006)
    assert in_floor_frame.centre[1] > 0, "y leads ahead, to where the camera looks"
    np.testing.assert_allclose(measured.world, VIEW, atol=1e-9)
    np.testing.assert_allclose(aligned_extents(in_world(only(measured), VIEW), crate()), only(measured).box.extents, atol=0.006)


def test_no_floor_is_no_world_of_its_own(floorless: Measurement) -> None:
    assert floorless.floor is None
    np.testing.assert_array_equal(floorless.world, np.eye(4))


def test_an_open_dimension_is_null_where_it_is_unbounded(opened: Measurement) -> None:
    content = written(opened)["boxes"][0]
    (place,) = [k for k, basis in enumerate(content["basis"]) if basis == "open"]
    assert content["sigma_m"][place] is None
    assert content["interval90_m"][place][1] is None
    assert content["volume_sigma_m3"] is None
    assert content["volume_interval90_m3"][1] is None
    assert "open" in content["flags"]
    seen = [k for k in range(3) if k != place]
    assert all(content["sigma_m"][k] is not None for k in seen)
    np.testing.assert_allclose(sorted(content["dimensions_m"][k] for k in seen), [0.3, 0.35], atol=0.006)


def test_an_open_dimension_is_reported_by_its_lower_bound(opened: Measurement) -> None:
    box = only(opened)
    place = box.basis.index("open")
    assert box.dimensions[place] == box.interval90[place][0]
    np.testing.assert_allclose(box.volume, np.prod(box.dimensions))
    assert box.volume <= 0.3 * 0.35 * 0.3


def test_the_reported_box_has_its_front_where_it_was_seen_even_where_its_depth_is_open(measured: Measurement) -> None:
    """Pose and dimensions are to be one box: an estimate of 0.35 m with a lower bound of 0.1 m behind a face that was seen."""
    box = only(measured)
    long = int(np.argmin(np.abs(box.box.extents - 0.35)))
    intervals = [*box.intervals]
    intervals[long] = Interval(0.1, np.inf, np.nan)
    cut_short = replace(box, intervals=tuple(intervals))
    content = cut_short.to_dict(np.eye(4))
    place, pose = content["basis"].index("open"), np.array(content["box_to_camera"])
    fronts = [
        min((centre + side * length / 2 * pose[:3, place] for side in (-1, 1)), key=lambda end: float(np.linalg.norm(end)))
        for centre, length in ((pose[:3, 3], content["dimensions_m"][place]), (box.box.centre, box.box.extents[long]))
    ]
    np.testing.assert_allclose(fronts[0], fronts[1], atol=1e-3)


@pytest.mark.parametrize(("axis", "seen", "end"), [(0, "+x", 1), (0, "-x", -1), (1, "+y", 1), (1, "-y", -1), (2, "top", -1)])
def test_of_an_open_dimension_the_end_that_was_seen_stays(measured: Measurement, axis: int, seen: str, end: int) -> None:
    """The face that was seen, which need not be the nearer one; of the height the floor."""
    whole = only(measured)
    intervals = [*whole.intervals]
    intervals[axis] = Interval(0.1, np.inf, np.nan)
    faces = (replace(whole.quality.faces[0], name=seen, returns=1000),)
    cut = replace(whole, intervals=tuple(intervals), quality=replace(whole.quality, faces=faces))
    placed, direction = cut.oriented(), whole.box.box_to_camera[:3, axis]
    assert abs(placed[:3, cut.basis.index("open")] @ direction) == pytest.approx(1)
    known = whole.box.centre + end * whole.box.extents[axis] / 2 * direction
    np.testing.assert_allclose(placed[:3, 3] + end * 0.05 * direction, known, atol=1e-9)


def test_a_lower_bound_as_written_is_not_above_the_dimension_as_written(measured: Measurement) -> None:
    """Of an open side they are the same number."""
    content = with_extents(only(measured), [0.3, 0.25, 0.2], low=0.123456).to_dict(np.eye(4))
    place = content["basis"].index("open")
    assert content["interval90_m"][place][0] <= content["dimensions_m"][place]


def test_the_volume_of_a_small_box_is_written_as_well_as_that_of_a_large_one(measured: Measurement) -> None:
    """Three significant digits of volume and sigma of a matchbox-sized box, which boxes of 2 cm height may be."""
    box = with_extents(only(measured), [0.05, 0.035, 0.02])
    content = box.to_dict(np.eye(4))
    np.testing.assert_allclose(content["volume_m3"], 0.05 * 0.035 * 0.02, rtol=1e-3)
    np.testing.assert_allclose(content["volume_sigma_m3"], box.volume_sigma, rtol=1e-2)


def test_rejected_objects_say_why_where_and_how_many() -> None:
    view = orbit_pose(np.array([0, 0, 0.12]), 0.4, np.deg2rad(35), 1.2)
    measurement = measure(shapes.scan_of(shapes.sphere(0.2), view, CAMERA, rng=np.random.default_rng(3)), camera=CAMERA)
    assert measurement.boxes == ()
    first = written(measurement)["rejected"][0]
    assert set(first) == {"reason", "returns", "centre_camera_m"}
    assert first["reason"] == measurement.reason == "not_a_box"
    assert first["returns"] > 1000
    centre = transform(view, np.array(first["centre_camera_m"]))
    assert np.linalg.norm(centre - [0, 0, 0.2]) < 0.2, "the seen side of the ball"
    assert written(measurement)["reason"] == "not_a_box"

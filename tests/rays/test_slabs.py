"""The slab test: against a ray-by-ray oracle made of corners, in single precision, for batches, and on torch tensors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.oracles.rays import corners_of, hit_box
from viewgain.box import Box
from viewgain.camera import Intrinsics
from viewgain.geometry import Plane, inverse, pose, rotation_from_rotvec, transform
from viewgain.rays import FACES_PER_BOX, NOTHING, BoxBody, bodies_in_camera, cast_slabs, pixel_rays
from viewgain.scenes import FLOOR, orbit_pose, standing_box, wall

Array = NDArray[np.float64]
CAMERA = Intrinsics.from_field_of_view(28, 21, *np.deg2rad([62.0, 45.0]))
DIRECTIONS = pixel_rays(CAMERA)
FACE_NAMES = ("+x", "-x", "+y", "-y", "top", "bottom")
numbers = st.floats(-1, 1)
triples = st.tuples(numbers, numbers, numbers)


def any_box(turn: tuple[float, ...], place: tuple[float, ...], extents: tuple[float, ...]) -> Box:
    """A box in any pose about two metres before a camera at the world's origin that looks along z."""
    place_ahead = np.array([place[0], place[1], place[2] + 2.2])
    return Box(pose(rotation_from_rotvec(3 * np.array(turn)), place_ahead), np.abs(extents) + 0.05)


def cast(boxes: list[Box], planes: list[Plane], camera: Array, directions: Any = DIRECTIONS) -> tuple[Any, Any, Any]:
    return cast_slabs(*bodies_in_camera(boxes, planes, camera), directions)


@settings(max_examples=30)
@given(triples, triples, triples)
def test_ranges_faces_and_cosines_are_the_oracles_for_a_box_in_any_pose(
    turn: tuple[float, ...], place: tuple[float, ...], extents: tuple[float, ...]
) -> None:
    """A ray that a nudge of 1e-7 takes past an edge is left to rounding."""
    box = any_box(turn, place, extents)
    ranges, surfaces, cosine = cast([box], [], np.eye(4))
    for k, ray in enumerate(np.stack(DIRECTIONS, axis=-1)):
        distance, facing, name = hit_box(box, np.zeros(3), ray)
        if np.isclose(ranges[k], distance, rtol=1e-9) or (np.isinf(ranges[k]) and np.isinf(distance)):
            if name is None:
                assert surfaces[k] == NOTHING
                assert cosine[k] == 0
            elif FACE_NAMES[surfaces[k]] == name:
                assert cosine[k] == pytest.approx(facing, abs=1e-9)
            else:
                assert on_an_edge(box, ray, distance)
        else:
            nudged = [hit_box(box, np.zeros(3), ray + np.array(n))[0] for n in np.vstack([np.eye(3), -np.eye(3)]) * 1e-7]
            assert np.ptp(np.minimum(nudged, 1e6)) > 1e-4


def on_an_edge(box: Box, ray: Array, distance: float) -> bool:
    """Whether a hit lies within 1e-6 m of two faces at once, where either may be named."""
    local = transform(inverse(box.box_to_camera), distance * ray) - [0, 0, box.extents[2] / 2]
    return bool(np.sum(np.abs(np.abs(local) - box.extents / 2) < 1e-6) >= 2)


def test_the_order_of_the_faces_is_the_boxs_own() -> None:
    """A camera out along each axis of an upright cube sees that face first."""
    box = standing_box(np.array([0.4, 0.4, 0.4]))
    for face, direction in enumerate(np.vstack([np.kron(np.eye(3), [[1], [-1]])])):
        camera = orbit_pose(box.centre, float(np.arctan2(direction[1], direction[0])), float(np.arcsin(direction[2])), 1.5)
        _, surfaces, cosine = cast([box], [], camera, (np.zeros(1), np.zeros(1), np.ones(1)))
        assert surfaces[0] == face
        assert cosine[0] == pytest.approx(1)


def test_planes_are_seen_from_their_front_only_and_come_after_the_boxes() -> None:
    box = standing_box(np.array([0.3, 0.3, 0.3]))
    camera = orbit_pose(box.centre, 0.3, 0.6, 1.4)
    ranges, surfaces, _ = cast([box], [FLOOR, wall(0.3 + np.pi, 0.8), wall(0.3, 0.5)], camera)
    assert set(np.unique(surfaces)) <= {NOTHING, *range(FACES_PER_BOX), FACES_PER_BOX, FACES_PER_BOX + 1}
    assert {FACES_PER_BOX, FACES_PER_BOX + 1} <= set(surfaces)  # the wall behind the camera is seen from its back: not at all
    from_below = orbit_pose(np.array([0.0, 0.0, -1.0]), 0.3, -0.3, 0.5)
    assert np.isinf(cast([], [FLOOR], from_below)[0]).all()
    assert np.isfinite(ranges[surfaces != NOTHING]).all()


@given(st.floats(0.2, 3), st.floats(0.1, 1.4))
def test_a_floor_is_met_at_height_over_cosine(height: float, tilt: float) -> None:
    camera = orbit_pose(np.zeros(3), 0.0, tilt, height / np.sin(tilt))
    ranges, _, cosine = cast([], [FLOOR], camera)
    down = -np.stack(DIRECTIONS, axis=-1) @ camera[:3, :3].T[:, 2]
    np.testing.assert_allclose(cosine, np.where(down > 1e-9, down, 0), atol=1e-12)
    np.testing.assert_allclose(ranges[down > 1e-6], height / down[down > 1e-6], rtol=1e-9)


def test_a_ray_along_an_axis_of_the_box_divides_by_nothing() -> None:
    box = standing_box(np.array([0.4, 0.3, 0.2]))
    camera = orbit_pose(box.centre, 0.0, 0.0, 1.0)
    with np.errstate(all="raise"):
        ranges, surfaces, cosine = cast([box], [], camera, tuple(np.array([c]) for c in (0.0, 0.0, 1.0)))
    assert (ranges[0], surfaces[0], cosine[0]) == (pytest.approx(0.8), 0, pytest.approx(1.0))


def test_a_camera_inside_a_box_sees_past_it() -> None:
    box = standing_box(np.array([2.0, 2.0, 2.0]))
    camera = orbit_pose(np.zeros(3), 0.0, 0.5, 0.5)
    ranges, surfaces, _ = cast([box], [FLOOR], camera)
    assert set(np.unique(surfaces)) <= {NOTHING, FACES_PER_BOX}
    np.testing.assert_array_equal(ranges, cast([], [FLOOR], camera)[0])


def test_a_box_behind_the_camera_is_not_seen() -> None:
    box = standing_box(np.array([0.3, 0.3, 0.3]))
    away = orbit_pose(box.centre, 0.0, 0.4, 1.0) @ pose(rotation_from_rotvec(np.array([0, np.pi, 0.0])), np.zeros(3))
    assert np.isinf(cast([box], [], away)[0]).all()


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_the_precision_of_the_rays_is_kept(kind: type) -> None:
    box = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4)
    camera = orbit_pose(box.centre, 0.7, 0.7, 1.2)
    exact = cast([box], [FLOOR], camera)
    ranges, surfaces, cosine = cast([box], [FLOOR], camera, tuple(d.astype(kind) for d in DIRECTIONS))
    assert ranges.dtype == cosine.dtype == kind
    assert surfaces.dtype == np.int32
    same = surfaces == exact[1]
    assert same.mean() > 0.99
    np.testing.assert_allclose(ranges[same], exact[0][same], rtol=1e-5)


def test_the_same_lines_run_on_torch_tensors_to_rounding() -> None:
    box = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4)
    camera = orbit_pose(box.centre, 0.7, 0.7, 1.2)
    boxes, planes = bodies_in_camera([box, standing_box(np.array([0.2, 0.2, 0.5]), at=(0.4, 0.3))], [FLOOR], camera)
    expected = cast_slabs(boxes, planes, DIRECTIONS)
    found = cast_slabs(boxes, planes, tuple(torch.from_numpy(np.array(d)) for d in DIRECTIONS))
    for value, tensor in zip(expected, found, strict=True):
        assert isinstance(tensor, torch.Tensor)
        np.testing.assert_allclose(tensor.numpy(), value, rtol=1e-13, atol=1e-14)  # one library fuses products and sums


@pytest.mark.parametrize("library", ["numpy", "torch"])
def test_a_batch_of_scenes_is_each_scene_by_itself(library: str) -> None:
    """The numbers of a body become (scenes, 1) arrays that broadcast against the rays."""
    rng = np.random.default_rng(3)
    each = []
    for _ in range(5):
        box = standing_box(rng.uniform(0.1, 0.5, 3), yaw=float(rng.uniform(0, 3)))
        each.append((box, orbit_pose(box.centre, float(rng.uniform(0, 6)), float(rng.uniform(0.3, 1.2)), 1.3)))
    to = (lambda a: torch.from_numpy(np.ascontiguousarray(a))) if library == "torch" else np.ascontiguousarray
    singles = [bodies_in_camera([box], [FLOOR], camera) for box, camera in each]

    def stacked(numbers: Any) -> Any:
        if isinstance(numbers[0], tuple):
            return tuple(stacked([n[k] for n in numbers]) for k in range(len(numbers[0])))
        return to(np.array(numbers)[:, None])

    bodies = [s[0][0] for s in singles]
    batch = BoxBody(*(stacked([getattr(b, name) for b in bodies]) for name in ("axes", "camera", "half")))
    floor = replace(
        singles[0][1][0],
        normal=stacked([s[1][0].normal for s in singles]),
        height=stacked([s[1][0].height for s in singles]),
    )
    rays = tuple(to(np.broadcast_to(d, (5, len(d)))) for d in DIRECTIONS)
    found = cast_slabs([batch], [floor], rays)
    for k, (boxes, planes) in enumerate(singles):
        for value, whole in zip(cast_slabs(boxes, planes, DIRECTIONS), found, strict=True):
            np.testing.assert_allclose(np.asarray(whole)[k], value, rtol=1e-12)


def test_corners_of_the_oracle_are_the_boxs() -> None:
    """The oracle builds its own corners; were they wrong, every agreement above would mean nothing."""
    box = any_box((0.3, -0.2, 0.5), (0.1, 0.0, 0.1), (0.4, 0.3, 0.2))
    np.testing.assert_allclose(np.sort(corners_of(box), axis=0), np.sort(box.corners(), axis=0), atol=1e-12)

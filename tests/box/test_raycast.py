"""Rays against box and floor: against a ray-by-ray polygon caster, against trimesh, and derivatives against differences."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.box.cases import boxes, rays_around
from tests.oracles.derivatives import along_steps
from tests.oracles.rays import QUADS, corners_of, hit_box
from viewgain.box import FACES, FLOOR, Box, box_hits, entry_mask, floor_hits, range_jacobian
from viewgain.geometry import inverse, transform

SLIVER_DEG = 1.3
"""Faces seen under less than 1.1 degrees are skipped on purpose; what is asked of them here begins a little above."""
CAMERA = np.zeros(3)


def has_sliver(box: Box) -> bool:
    """Whether some face, as a plane, is seen under nearly no angle."""
    origin = -box.box_to_camera[:3, :3].T @ box.box_to_camera[:3, 3]
    heights = [abs(origin[0]) - box.extents[0] / 2, abs(origin[1]) - box.extents[1] / 2, origin[2] - box.extents[2]]
    return any(0 < height < np.sin(np.deg2rad(SLIVER_DEG)) * np.linalg.norm(origin) for height in heights)


def near_an_edge(box: Box, ray: np.ndarray, name: str | None) -> bool:
    """Whether a tiny change of the ray changes the face that it meets: rounding decides there."""
    nudges = 1e-7 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    return any(hit_box(box, CAMERA, (ray + nudge) / np.linalg.norm(ray + nudge))[2] != name for nudge in nudges)


@settings(max_examples=30)
@given(boxes, st.integers(0, 10_000))
def test_hits_ranges_faces_and_cosines_are_those_of_the_polygons(box: Box, seed: int) -> None:
    rays = rays_around(box, 25, seed)
    mask, hits = entry_mask(box, rays), box_hits(box, rays)
    for k, ray in enumerate(rays):
        distance, cosine, name = hit_box(box, CAMERA, ray)
        if near_an_edge(box, ray, name):
            continue
        assert mask[k] == math.isfinite(distance)
        if math.isfinite(distance) and name != "bottom" and not has_sliver(box):
            np.testing.assert_allclose(hits.ranges[k], distance, rtol=1e-9)
            np.testing.assert_allclose(hits.cosine[k], cosine, atol=1e-9)
            assert FACES[hits.planes[k]] == name


def nearest_triangle(box: Box, rays: np.ndarray) -> np.ndarray:
    """Return (n,) distances to trimesh's mesh of the box, every ray against every triangle; inf for a miss."""
    mesh = trimesh.creation.box(extents=box.extents)
    mesh.apply_translation([0, 0, box.extents[2] / 2])
    mesh.apply_transform(box.box_to_camera)
    ray, triangle = np.indices((len(rays), len(mesh.faces))).reshape(2, -1)
    points, valid = trimesh.intersections.planes_lines(
        mesh.triangles[triangle, 0], mesh.face_normals[triangle], np.zeros((len(ray), 3)), rays[ray]
    )
    ray, triangle = ray[valid], triangle[valid]
    weights = trimesh.triangles.points_to_barycentric(mesh.triangles[triangle], points)
    inside = (weights >= -1e-12).all(axis=1) & (np.sum(points * rays[ray], axis=1) > 0)
    nearest = np.full(len(rays), np.inf)
    np.minimum.at(nearest, ray[inside], np.linalg.norm(points[inside], axis=1))
    return nearest


@settings(max_examples=30)
@given(boxes, st.integers(0, 10_000))
def test_hits_are_those_of_trimesh(box: Box, seed: int) -> None:
    rays = rays_around(box, 60, seed)
    nearest, mask, hits = nearest_triangle(box, rays), entry_mask(box, rays), box_hits(box, rays)
    nudges = 1e-7 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    clear = np.all([np.isfinite(nearest_triangle(box, rays + nudge)) == np.isfinite(nearest) for nudge in nudges], axis=0)
    np.testing.assert_array_equal(mask[clear], np.isfinite(nearest)[clear])
    if not has_sliver(box) and box.floor.offset > 0:
        both = clear & mask
        np.testing.assert_allclose(hits.ranges[both], nearest[both], rtol=1e-8)


@given(boxes, st.integers(0, 10_000))
def test_rays_past_the_outline_meet_the_plane_of_a_visible_face(box: Box, seed: int) -> None:
    """The continuation that makes the likelihood smooth: the same plane, beyond its edge."""
    rays = rays_around(box, 40, seed)
    hits = box_hits(box, rays)
    found = np.flatnonzero(np.isfinite(hits.ranges))
    local = transform(inverse(box.box_to_camera), rays[found] * hits.ranges[found, None])
    plane = np.array([[0.5, 0], [-0.5, 0], [0, 0.5], [0, -0.5]])
    for point, face in zip(local, hits.planes[found], strict=True):
        if face == 4:
            np.testing.assert_allclose(point[2], box.extents[2], rtol=1e-7)
        else:
            axis = int(face) // 2
            np.testing.assert_allclose(point[axis], plane[face, axis] * box.extents[axis], rtol=1e-6, atol=1e-9)
    assert np.all(hits.cosine >= 0)
    assert np.all(hits.cosine <= 1 + 1e-12)


def test_a_camera_inside_the_box_sees_no_face() -> None:
    box = Box(np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.5], [0, 0, 0, 1.0]]), np.ones(3))
    rays = rays_around(box, 20, 0)
    assert np.all(np.isinf(box_hits(box, rays).ranges))
    assert np.all(entry_mask(box, rays))


def test_a_box_behind_the_camera_is_not_hit() -> None:
    pose = np.eye(4)
    pose[2, 3] = -3.0
    box = Box(pose, np.array([0.5, 0.5, 1.0]))
    assert not entry_mask(box, np.array([[0.0, 0.0, 1.0], [0.0, 0.1, 0.995]])).any()


@given(boxes, st.integers(0, 10_000))
def test_floor_hits_lie_on_the_floor(box: Box, seed: int) -> None:
    rays = np.random.default_rng(seed).normal(size=(40, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    hits = floor_hits(box, rays)
    down = rays @ box.floor.normal < -1e-5
    assert np.all(np.isinf(hits.ranges[rays @ box.floor.normal >= 0]))
    assert np.all(hits.planes == FLOOR)
    if box.floor.offset > 0:
        points = rays[down] * hits.ranges[down, None]
        np.testing.assert_allclose(box.floor.height(points), 0, atol=1e-9)
        np.testing.assert_allclose(hits.cosine[down], -(rays[down] @ box.floor.normal), atol=1e-12)


@settings(max_examples=25)
@given(boxes, st.integers(0, 10_000))
def test_the_derivative_of_the_ranges_is_their_central_difference(box: Box, seed: int) -> None:
    """Where the same face is met on both sides and under more than 6 degrees; the error of a difference is step^2 / cos^3."""
    rays = rays_around(box, 40, seed)
    step = 1e-6
    for meet in (box_hits, floor_hits):
        hits = meet(box, rays)
        ahead = np.flatnonzero(np.isfinite(hits.ranges) & (hits.cosine > 0.1))
        slopes = along_steps(lambda moved, meet=meet, ahead=ahead: meet(moved, rays[ahead]).ranges, box, step)
        faces = along_steps(lambda moved, meet=meet, ahead=ahead: meet(moved, rays[ahead]).planes.astype(float), box, step)
        steady = np.abs(faces).max(axis=1, initial=0) == 0
        jacobian = range_jacobian(box, rays[ahead], hits.take(ahead))
        np.testing.assert_allclose(jacobian[steady], slopes[steady], rtol=1e-4, atol=1e-5)


def test_the_derivative_by_hand_head_on() -> None:
    """A camera 2 m above a box 0.5 m high: raising the top by d shortens the range by d, whatever raises it."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 2.0
    box = Box(pose, np.array([1.0, 1.0, 0.5]))
    ray = np.array([[0.0, 0.0, 1.0]])
    hits = box_hits(box, ray)
    np.testing.assert_allclose(hits.ranges, 1.5)
    np.testing.assert_allclose(range_jacobian(box, ray, hits), [[0, 0, 0, 0, 0, -1, 0, 0, -1]], atol=1e-15)
    ground = floor_hits(box, ray)
    np.testing.assert_allclose(ground.ranges, 2.0)
    np.testing.assert_allclose(range_jacobian(box, ray, ground), [[0, 0, 0, 0, 0, -1, 0, 0, 0]], atol=1e-15)


def test_a_subset_of_hits_keeps_each_rays_own() -> None:
    box = Box(np.array([[1, 0, 0, 0], [0, 0, -1, 0.3], [0, 1, 0, 2], [0, 0, 0, 1.0]]), np.array([0.5, 0.5, 0.5]))
    rays = rays_around(box, 30, 1)
    chosen = np.array([3, 17, 4])
    hits, part = box_hits(box, rays), box_hits(box, rays).take(chosen)
    np.testing.assert_array_equal(part.ranges, hits.ranges[chosen])
    np.testing.assert_array_equal(part.planes, hits.planes[chosen])
    np.testing.assert_array_equal(part.cosine, hits.cosine[chosen])


@pytest.mark.parametrize("name", [*FACES, "bottom"])
def test_the_oracle_itself_meets_each_face_from_outside(name: str) -> None:
    box = Box(np.eye(4), np.array([0.4, 0.6, 0.8]))
    middle = corners_of(box)[list(QUADS[name])].mean(axis=0)
    outwards = middle - box.centre
    outwards /= np.linalg.norm(outwards)
    distance, cosine, found = hit_box(box, middle + 2 * outwards, -outwards)
    assert found == name
    np.testing.assert_allclose((distance, cosine), (2, 1))

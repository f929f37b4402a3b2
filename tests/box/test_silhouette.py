"""The outline: against scipy's convex hull, distances against segments, and derivatives against differences."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from tests.box.cases import boxes, rays_around
from tests.oracles.derivatives import along_steps
from tests.oracles.rays import corners_of, to_segment
from viewgain.box import Box, edge_distances, edge_jacobian, entry_mask, outline


def projected(box: Box) -> np.ndarray:
    corners = corners_of(box)
    return corners[:, :2] / corners[:, 2:]


@given(boxes)
def test_the_outline_is_the_convex_hull_of_the_projected_corners(box: Box) -> None:
    points, shape = projected(box), outline(box)
    hull = ConvexHull(points)
    np.testing.assert_allclose(shape.vertices, points[shape.corners], atol=1e-12)
    x, y = shape.vertices.T
    area = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    np.testing.assert_allclose(area, hull.volume, rtol=1e-9)  # positive: counter-clockwise
    length = np.linalg.norm(np.roll(shape.vertices, -1, axis=0) - shape.vertices, axis=1).sum()
    np.testing.assert_allclose(length, hull.area, rtol=1e-9)
    assert len(set(shape.corners.tolist())) == len(shape.corners) in (4, 5, 6)


@settings(max_examples=30)
@given(boxes, st.integers(0, 10_000))
def test_the_sign_of_the_distance_tells_which_rays_hit(box: Box, seed: int) -> None:
    rays = rays_around(box, 200, seed)
    distance = edge_distances(outline(box), rays[:, :2] / rays[:, 2:]).distance
    clear = np.abs(distance) > 1e-9
    np.testing.assert_array_equal((distance > 0)[clear], entry_mask(box, rays)[clear])


@settings(max_examples=30)
@given(boxes, st.integers(0, 10_000))
def test_the_distance_is_that_to_the_nearest_side(box: Box, seed: int) -> None:
    """Exact inside; outside beside a vertex it is to the farther side's line, which is never more than the true distance."""
    rays = rays_around(box, 60, seed)
    points, shape = rays[:, :2] / rays[:, 2:], outline(box)
    found = edge_distances(shape, points)
    ends = np.roll(shape.vertices, -1, axis=0)
    for k, point in enumerate(points):
        true = min(to_segment(point, start, end) for start, end in zip(shape.vertices, ends, strict=True))
        if found.distance[k] >= 0:
            np.testing.assert_allclose(found.distance[k], true, atol=1e-9)
        else:
            assert -found.distance[k] <= true + 1e-9
            if 0 < found.along[k] < 1:
                on_line = to_segment(point, shape.vertices[found.edge[k]], ends[found.edge[k]])
                np.testing.assert_allclose(-found.distance[k], on_line, atol=1e-9)


def test_along_is_the_share_of_the_side_up_to_the_foot_point() -> None:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 2.0
    shape = outline(Box(pose, np.array([2.0, 2.0, 1.0])))  # straight above: a square from -1 to 1 at depth 1
    found = edge_distances(shape, np.array([[0.5, 0.9], [0.5, 1.2], [0.9, -0.2], [3.0, 5.0]]))
    np.testing.assert_allclose(found.distance, [0.1, -0.2, 0.1, -4.0], atol=1e-12)
    feet = shape.vertices[found.edge] + found.along[:, None] * (
        np.roll(shape.vertices, -1, axis=0)[found.edge] - shape.vertices[found.edge]
    )
    np.testing.assert_allclose(feet, [[0.5, 1.0], [0.5, 1.0], [1.0, -0.2], [1.0, 1.0]], atol=1e-12)


@settings(max_examples=25)
@given(boxes, st.integers(0, 10_000))
def test_the_derivative_of_the_distance_is_its_central_difference(box: Box, seed: int) -> None:
    """Where the foot point lies on the side and the nearest side and the outline's corners stay the same ones."""
    rays = rays_around(box, 40, seed)
    points, shape = rays[:, :2] / rays[:, 2:], outline(box)
    if np.min(np.linalg.norm(np.roll(shape.vertices, -1, axis=0) - shape.vertices, axis=1)) < 1e-3:
        return  # a sliver of a side: the corners of the outline change within any step
    distances = edge_distances(shape, points)
    # A difference over 2e-6 of a distance with curvature of up to 1e3 (depth 0.2 m) errs by 1e-9 / step = 1e-3 relative.
    slopes = along_steps(lambda moved: edge_distances(outline(moved), points).distance, box, 1e-6)
    edges = along_steps(lambda moved: edge_distances(outline(moved), points).edge.astype(float), box, 1e-6)
    corners = {len(outline(box.moved(step)).corners) for step in 1e-6 * np.vstack([np.eye(9), -np.eye(9)])}
    steady = (np.abs(edges).max(axis=1) == 0) & (distances.along > 0) & (distances.along < 1)
    if len(corners) == 1:
        jacobian = edge_jacobian(box, shape, distances)
        np.testing.assert_allclose(jacobian[steady], slopes[steady], rtol=1e-4, atol=1e-5)


def test_a_box_partly_behind_the_camera_still_has_an_outline() -> None:
    pose = np.eye(4)
    pose[:3, 3] = [0.0, 0.3, 0.2]
    shape = outline(Box(pose, np.array([0.5, 0.5, 0.6])))
    assert np.all(np.isfinite(shape.vertices))
    assert len(shape.corners) >= 4

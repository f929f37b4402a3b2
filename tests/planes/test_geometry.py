"""Normals, corners, refinement, ends: each against a slower or an independent way to the same number."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

from tests.planes.clouds import seen_corner, three_faces
from viewgain.geometry import rotation_from_rotvec
from viewgain.planes import AS_PUBLISHED, MENDED
from viewgain.planes._cloud import Cloud
from viewgain.planes._corners import fitted_corner, meeting_point
from viewgain.planes._ends import half_density_ends, raw_ends
from viewgain.planes._lines import line_segments
from viewgain.planes._normals import cloud_normals, image_normals, least_eigenvector
from viewgain.planes._parallel import Planes, merged
from viewgain.planes._refine import refined

DIMS = np.array([0.4, 0.3, 0.2])


@given(st.integers(0, 10**6))
def test_the_least_eigenvector_is_that_of_lapack(seed: int) -> None:
    half = np.random.default_rng(seed).normal(size=(20, 3, 3))
    matrix = half @ half.transpose(0, 2, 1) + np.eye(3) * 0.01
    entries = [matrix[:, i, j] for i in range(3) for j in range(i, 3)]
    values, vectors = np.linalg.eigh(matrix)
    clear = values[:, 1] - values[:, 0] > 1e-3 * values[:, 2]
    cosine = np.abs(np.sum(least_eigenvector(*entries) * vectors[:, :, 0], axis=1))
    np.testing.assert_allclose(cosine[clear], 1, atol=1e-6)


def waves() -> np.ndarray:
    v, u = np.mgrid[-20:21, -30:31] * 0.005
    return np.stack([u, v, 1 + 0.05 * np.sin(12 * u) + 0.04 * v + np.random.default_rng(0).normal(0, 0.002, u.shape)], axis=2)


def test_image_and_cloud_normals_are_those_of_the_ball_one_point_at_a_time() -> None:
    image, radius = waves(), 0.02
    points = image.reshape(-1, 3)
    tree = cKDTree(points)
    slow = []
    for point in points:
        near = points[tree.query_ball_point(point, radius)]
        vector = np.linalg.eigh(np.cov(near.T))[1][:, 0]
        slow.append(vector * -np.sign(vector @ point))
    for fast in (cloud_normals(points, radius), image_normals(image, 0.02).reshape(-1, 3)):
        known = np.isfinite(fast[:, 0])
        assert known.all()
        cosine = np.sum(fast * slow, axis=1)
        assert np.quantile(cosine, 0.05) > 0.999


def test_block_normals_follow_the_same_surface() -> None:
    image = waves()
    cosine = np.sum(image_normals(image, 0.03) * image_normals(image, 0.03, blocks=True), axis=2)
    assert np.quantile(cosine, 0.05) > 0.95


def test_missing_points_have_no_normals_and_no_warnings() -> None:
    image = waves()
    image[::3] = np.nan
    normals = image_normals(image, 0.02)
    assert np.isnan(normals[::3]).all()
    assert np.isfinite(normals[1::3]).all()
    assert np.isnan(image_normals(np.full((5, 5, 3), np.nan), 0.02)).all()


def test_a_corner_fit_is_that_of_a_general_solver() -> None:
    pose, rng = seen_corner(0.3), np.random.default_rng(6)
    cloud = three_faces(np.full(3, 0.12), pose)
    points = cloud.points + rng.normal(0, 0.003, cloud.points.shape)
    axes = rotation_from_rotvec(np.array([0.05, -0.04, 0.03])) @ pose[:3, :3].T
    offsets = -axes @ (pose[:3, 3] + 0.01)
    corner = fitted_corner(axes, offsets, points)

    def residual(x: np.ndarray) -> np.ndarray:
        return np.min(np.abs(points @ (rotation_from_rotvec(x[:3]) @ axes).T + offsets + x[3:]), axis=1)

    solved = least_squares(residual, np.zeros(6), xtol=1e-12, ftol=1e-12).x
    turned = rotation_from_rotvec(solved[:3]) @ axes
    assert corner is not None
    np.testing.assert_allclose(corner.position, -turned.T @ (offsets + solved[3:]), atol=3e-4)
    np.testing.assert_allclose(corner.axes @ corner.axes.T, np.eye(3), atol=1e-9)


def test_three_planes_meet_where_the_corner_is() -> None:
    pose = seen_corner()
    np.testing.assert_allclose(meeting_point(pose[:3, :3].T, -pose[:3, :3].T @ pose[:3, 3]), pose[:3, 3], atol=1e-12)


def test_the_joint_refinement_finds_the_true_planes_from_a_few_degrees_and_centimetres_off() -> None:
    pose = seen_corner()
    cloud = three_faces(DIMS, pose)
    axes = pose[:3, :3].T @ rotation_from_rotvec(np.array([0.06, -0.05, 0.04])).T
    start = Planes(axes, np.arange(3), -axes @ pose[:3, 3] + 0.02, np.array([[0, 1], [0, 2], [1, 2]]))
    planes = refined(start, cloud, replace(AS_PUBLISHED, normal_gate=0.5))
    np.testing.assert_allclose(planes.normals, pose[:3, :3].T, atol=1e-3)
    np.testing.assert_allclose(planes.offsets, -pose[:3, :3].T @ pose[:3, 3], atol=1e-3)


def test_merging_opposed_normals_keeps_the_plane_only_when_mended() -> None:
    planes = Planes(np.array([[0, 0, 1.0], [0, 0, -1.0]]), np.array([0, 1]), np.array([-1.0, 1.0]), np.empty((0, 2), dtype=int))
    np.testing.assert_allclose(merged(planes, MENDED).offsets, [-1.0])
    np.testing.assert_allclose(merged(planes, AS_PUBLISHED).offsets, [-1.0, 1.0])


def test_a_thin_box_is_fused_with_the_floor_only_as_published() -> None:
    planes = Planes(np.array([[0, 0, 1.0]]), np.zeros(2, dtype=int), np.array([-1.0, -1.07]), np.empty((0, 2), dtype=int))
    assert len(merged(planes, AS_PUBLISHED)) == 1
    assert len(merged(planes, MENDED)) == 2


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.01])
def test_soft_ends_are_where_points_end_whatever_the_noise_and_strays(noise: float) -> None:
    rng = np.random.default_rng(7)
    along = np.concatenate([rng.uniform(0.1, 0.5, 4000) + rng.normal(0, noise, 4000), rng.uniform(-0.2, 0.8, 40)])
    np.testing.assert_allclose(half_density_ends(along, np.ones(len(along))), (0.1, 0.5), atol=0.004)
    assert raw_ends(along)[0] < 0.0


def test_planes_whose_points_do_not_overlap_make_a_reversed_segment_only_as_published() -> None:
    along = np.linspace(0, 0.2, 50)
    one = np.column_stack([np.zeros(50), np.full(50, 0.01), 1.0 + along])
    other = np.column_stack([np.full(50, 0.01), np.zeros(50), 1.5 + along])
    cloud = Cloud(np.concatenate([one, other]), np.repeat(np.eye(3)[:2], 50, axis=0))
    planes = Planes(np.eye(3)[:2], np.arange(2), np.zeros(2), np.empty((0, 2), dtype=int))
    published = line_segments(planes, cloud, AS_PUBLISHED)
    np.testing.assert_allclose(published.lengths, 0.3, atol=1e-9)
    assert published.high[0] < published.low[0]
    assert len(line_segments(planes, cloud, replace(AS_PUBLISHED, forward_only=True))) == 0

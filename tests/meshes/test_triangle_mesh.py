"""The laws of areas, boxes and normals, and what is no mesh."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.meshes import files
from viewgain.errors import MeshError
from viewgain.meshes import TriangleMesh

PYRAMID = TriangleMesh(files.VERTICES, files.TRIANGLES, "pyramid")

seeds = st.integers(0, 2**32 - 1)


def random_mesh(seed: int) -> TriangleMesh:
    """Triangles anywhere, at any size from a millimetre to a hundred metres."""
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(12, 3)) * 10 ** rng.uniform(-3, 2)
    return TriangleMesh(vertices, rng.permuted(np.tile(np.arange(12), (20, 1)), axis=1)[:, :3])


def random_pose(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    pose[:3, 3] = rng.normal(size=3)
    return pose


def test_a_pyramid_by_hand() -> None:
    # Sides 1 x 2 and height 3 above (0.25, 0.5): each face's half base times its slant height.
    slants = [1 * np.hypot(3, 0.5), 2 * np.hypot(3, 0.75), 1 * np.hypot(3, 1.5), 2 * np.hypot(3, 0.25)]
    assert PYRAMID.area == pytest.approx(2 + sum(slants) / 2)
    np.testing.assert_array_equal(PYRAMID.bounds, [[0, 0, 0], [1, 2, 3]])
    np.testing.assert_array_equal(PYRAMID.extents, [1, 2, 3])
    np.testing.assert_array_equal(PYRAMID.face_normals[:2], [[0, 0, -1], [0, 0, -1]])
    np.testing.assert_array_equal(PYRAMID.triangles[2], [[0, 0, 0], [1, 0, 0], [0.25, 0.5, 3]])


@given(seeds, seeds)
def test_a_rigid_motion_keeps_areas_and_turns_normals(seed: int, motion: int) -> None:
    mesh, pose = random_mesh(seed), random_pose(motion)
    moved = mesh.moved(pose)
    # Rounding: the translation of about a metre costs digits of a mesh of a millimetre, a thousandth of it, squared no more.
    np.testing.assert_allclose(moved.face_areas, mesh.face_areas, rtol=1e-9, atol=1e-12 * mesh.area)
    thick = mesh.face_areas > 1e-3 * mesh.face_areas.max()  # a sliver's normal is ill-defined
    np.testing.assert_allclose(moved.face_normals[thick], mesh.face_normals[thick] @ pose[:3, :3].T, atol=1e-8)


@given(seeds, st.floats(1e-3, 1e3))
def test_area_grows_with_the_square_of_the_scale(seed: int, factor: float) -> None:
    mesh = random_mesh(seed)
    assert mesh.scaled(factor).area == pytest.approx(mesh.area * factor**2, rel=1e-12)
    np.testing.assert_allclose(mesh.scaled(factor).bounds, mesh.bounds * factor, rtol=1e-12)


@given(seeds, st.floats(1e-3, 1e3))
def test_normalised_is_centred_with_the_diagonal_asked_for(seed: int, diagonal: float) -> None:
    mesh = random_mesh(seed).normalised(diagonal)
    assert np.linalg.norm(mesh.extents) == pytest.approx(diagonal, rel=1e-12)
    np.testing.assert_allclose(mesh.bounds.sum(axis=0), 0, atol=1e-12 * diagonal)


@given(seeds, seeds)
def test_normalised_forgets_where_the_mesh_was_and_how_large(seed: int, other: int) -> None:
    mesh, rng = random_mesh(seed), np.random.default_rng(other)
    pose = np.eye(4)
    pose[:3, 3] = rng.normal(size=3)
    moved = mesh.moved(pose).scaled(rng.uniform(0.1, 10))
    np.testing.assert_allclose(moved.normalised().vertices, mesh.normalised().vertices, atol=1e-10)


@given(seeds, st.floats(-10, 10), st.floats(-10, 10))
def test_standing_touches_the_floor_and_keeps_the_shape(seed: int, x: float, y: float) -> None:
    mesh = random_mesh(seed)
    standing = mesh.standing(at=(x, y))
    low, high = standing.bounds
    assert low[2] == 0
    np.testing.assert_allclose((low + high)[:2] / 2, [x, y], atol=1e-12 * (10 + np.abs(mesh.vertices).max()))
    assert standing.area == pytest.approx(mesh.area, rel=1e-9)


@given(seeds)
def test_normals_have_unit_length_or_none(seed: int) -> None:
    mesh = random_mesh(seed)
    flat = TriangleMesh(mesh.vertices, np.vstack([mesh.faces, [[0, 0, 1]]]))
    lengths = np.linalg.norm(flat.face_normals, axis=1)
    np.testing.assert_allclose(lengths[:-1], 1, rtol=1e-12)
    assert lengths[-1] == 0
    assert flat.face_areas[-1] == 0


def test_areas_of_many_triangles_come_in_their_order() -> None:
    # More than the areas are computed at a time.
    heights = np.arange(1, 300_001)
    vertices = np.vstack([[[0, 0, 0], [1, 0, 0]], np.column_stack([0 * heights, heights, 0 * heights])])
    faces = np.column_stack([0 * heights, 0 * heights + 1, heights + 1])
    np.testing.assert_array_equal(TriangleMesh(vertices, faces).face_areas, heights / 2)


def test_unused_vertices_count_for_nothing() -> None:
    mesh = TriangleMesh(np.vstack([files.VERTICES, [[np.nan, np.inf, 99]]]), files.TRIANGLES)
    np.testing.assert_array_equal(mesh.bounds, PYRAMID.bounds)
    assert mesh.area == PYRAMID.area


@pytest.mark.parametrize(
    ("vertices", "faces", "expected"),
    [
        (np.zeros((3, 2)), [[0, 1, 2]], "wanted (v, 3) and (f, 3)"),
        (files.VERTICES, [[0, 1, 2, 3]], "wanted (v, 3) and (f, 3)"),
        (files.VERTICES, np.zeros((0, 3), int), "at least one triangle"),
        (np.zeros((0, 3)), [[0, 1, 2]], "at least one triangle"),
        (files.VERTICES, [[0, 1, 5]], "there are 5"),
        (files.VERTICES, [[0, 1, -1]], "there are 5"),
        (files.VERTICES, [[0, 1, 2**32 + 2]], "there are 5"),
        (files.VERTICES, [[0.0, 1.0, 2.0]], "wanted integers"),
        (files.VERTICES * np.nan, [[0, 1, 2]], "not finite"),
        (files.VERTICES * 0, [[0, 1, 2]], "no area"),
        (files.VERTICES * 1e200, [[0, 1, 2]], "too large"),
    ],
)
def test_what_is_no_mesh(vertices: np.ndarray, faces: object, expected: str) -> None:
    with pytest.raises(MeshError) as caught:
        TriangleMesh(vertices, np.asarray(faces), "thing")
    assert str(caught.value).startswith("thing: ")
    assert expected in str(caught.value)


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_a_scale_must_be_positive(factor: float) -> None:
    with pytest.raises(MeshError, match="positive"):
        PYRAMID.scaled(factor)


def test_faces_of_any_integers_become_int32(tmp_path: Path) -> None:
    for kind in (np.uint8, np.int16, np.uint32, np.int64, ">i4"):
        assert TriangleMesh(files.VERTICES, files.TRIANGLES.astype(kind)).faces.dtype == np.int32

"""Casting without any library, and what all ways of casting share."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.triangles import block, block_ranges, bumpy_sphere, first_hits, soup, unit_rays
from viewgain.geometry import pose, rotation_from_rotvec, transform
from viewgain.meshes import TriangleMesh
from viewgain.rays._triangles import cast_plain, face_planes, incidence_cosines, plane_ranges

SEEDS = st.integers(0, 2**32 - 1)
LOW, HIGH = np.array([-0.3, -0.2, 0.1]), np.array([0.5, 0.4, 0.9])
ORIGIN = np.array([0.1, 0.05, -1.5])
TRIANGLE = TriangleMesh(np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]]), np.array([[0, 1, 2]]))
FORWARD = np.array([0.0, 0.0, 1.0])


@given(seed=SEEDS, shared=st.booleans())
def test_a_soup_agrees_with_the_ray_by_ray_twin(seed: int, shared: bool) -> None:
    """Rays within 1e-6 m of an edge, or of a second surface, are left to rounding: fewer than one in twenty may be."""
    rng = np.random.default_rng(seed)
    mesh, directions = soup(rng), unit_rays(rng, 40)
    origins = rng.normal(scale=0.3, size=3) if shared else rng.normal(scale=0.3, size=(40, 3))
    ranges, triangles = cast_plain(mesh, origins, directions)
    expected, index, cosines, clear = first_hits(mesh, origins, directions)
    assert clear.mean() > 0.95
    np.testing.assert_array_equal(triangles[clear], index[clear])
    # Rounding alone: a hit at a cosine of 1e-6, rarer than any seed here finds, would still be good to 1e-9.
    np.testing.assert_allclose(ranges[clear], expected[clear], rtol=1e-9)
    found = incidence_cosines(face_planes(mesh), triangles, directions)
    np.testing.assert_allclose(found[clear], cosines[clear], atol=1e-12)


@pytest.mark.parametrize("origin", [ORIGIN, np.array([0.1, 0.1, 0.5])], ids=["outside", "inside"])
def test_a_box_is_hit_where_its_slabs_say(origin: np.ndarray) -> None:
    directions = unit_rays(np.random.default_rng(1), 3000)
    ranges, triangles = cast_plain(block(LOW, HIGH), origin, directions)
    expected = block_ranges(LOW, HIGH, origin, directions)
    np.testing.assert_allclose(ranges, expected, rtol=1e-12)  # rounding alone
    np.testing.assert_array_equal(triangles >= 0, np.isfinite(expected))
    assert triangles.dtype == np.int32


def test_a_ball_is_hit_between_its_facets_and_its_hull() -> None:
    """From the middle: no range exceeds the radius, and none falls short of it by more than the facets do."""
    polar, turn = np.meshgrid(np.linspace(0.1, np.pi - 0.1, 24), np.linspace(0, 2 * np.pi, 48), indexing="ij")
    points = 2 * np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
    a = (np.arange(23)[:, None] * 48 + np.arange(47)).ravel()
    faces = np.concatenate([np.stack([a, a + 48, a + 49], axis=1), np.stack([a, a + 49, a + 1], axis=1)])
    directions = unit_rays(np.random.default_rng(2), 2000)
    directions = directions[np.abs(directions[:, 2]) < 0.98]  # the caps of this ball are open
    ranges, triangles = cast_plain(TriangleMesh(points.reshape(-1, 3), faces), np.zeros(3), directions)
    assert np.all(ranges <= 2 + 1e-12)
    assert np.all(ranges > 2 * np.cos(0.14))  # half the diagonal of a facet spans less than this angle
    assert incidence_cosines(face_planes(TriangleMesh(points.reshape(-1, 3), faces)), triangles, directions).min() > np.cos(0.14)


def test_both_sides_count_and_beside_is_a_miss() -> None:
    origins = np.array([[0.2, 0.2, 0.0], [0.2, 0.2, 3.0], [0.7, 0.7, 0.0], [0.2, 0.2, 0.0]])
    directions = np.array([FORWARD, -FORWARD, FORWARD, -FORWARD])
    ranges, triangles = cast_plain(TRIANGLE, origins, directions)
    np.testing.assert_allclose(ranges, [1, 2, np.inf, np.inf], rtol=1e-15)
    np.testing.assert_array_equal(triangles, [0, 0, -1, -1])
    np.testing.assert_allclose(incidence_cosines(face_planes(TRIANGLE), triangles, directions), [1, 1, 0, 0])


@pytest.mark.parametrize("shared", [True, False])
def test_edges_and_corners_belong_to_the_triangle(shared: bool) -> None:
    targets = np.array([[0.5, 0, 1], [0, 0.5, 1], [0.5, 0.5, 1], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
    directions = targets / np.linalg.norm(targets, axis=1, keepdims=True)
    _, triangles = cast_plain(TRIANGLE, np.zeros(3) if shared else np.zeros((6, 3)), directions)
    np.testing.assert_array_equal(triangles, 0)


def test_no_ray_slips_between_neighbours() -> None:
    """From inside a closed mesh, at its own corners and the middles of its edges."""
    mesh = bumpy_sphere(12, 16)
    middles = mesh.triangles.mean(axis=1), (mesh.triangles[:, 0] + mesh.triangles[:, 1]) / 2
    targets = np.concatenate([mesh.vertices, *middles])
    ranges, _ = cast_plain(mesh, np.zeros(3), targets / np.linalg.norm(targets, axis=1, keepdims=True))
    assert np.all(np.isfinite(ranges))


def test_of_equal_triangles_the_first_is_hit() -> None:
    twice = TriangleMesh(TRIANGLE.vertices, np.array([[0, 0, 1], [0, 1, 2], [0, 1, 2], [1, 2, 0]]))
    _, triangles = cast_plain(twice, np.array([0.2, 0.2, 0.0]), FORWARD[None])
    assert triangles[0] == 1


def test_a_degenerate_triangle_is_never_hit() -> None:
    """A point, a repeated corner, three corners in a line, a line that rounding has bent."""
    bent = np.array([[0, 0, 2], [0.1, 0.1, 2], [0.3, 0.3 + 1e-17, 2], [0.7, 0.7, 2 + 2e-16]])
    mesh = TriangleMesh(np.vstack([TRIANGLE.vertices, bent]), np.array([[3, 3, 3], [3, 4, 4], [3, 4, 6], [3, 5, 6], [0, 1, 2]]))
    targets = np.array([[0.1, 0.1, 2], [0.2, 0.2, 2], [0.65, 0.65, 2]])  # the last passes beside the one true triangle
    ranges, triangles = cast_plain(
        mesh, np.array([0.05, 0.05, 0.0]) * [0, 0, 1], targets / np.linalg.norm(targets, axis=1)[:, None]
    )
    np.testing.assert_array_equal(face_planes(mesh)[:4], 0.0)
    np.testing.assert_array_equal(triangles, 4)
    assert np.all(ranges < 1.5)


def test_a_ray_in_the_plane_of_a_triangle_misses_it() -> None:
    ranges, triangles = cast_plain(TRIANGLE, np.array([-1.0, 0.2, 1.0]), np.array([[1.0, 0, 0], [0.6, 0.8, 0]]))
    assert np.all(np.isinf(ranges))
    np.testing.assert_array_equal(triangles, -1)
    rng = np.random.default_rng(6)
    for _ in range(50):  # in the plane to rounding only, and through the triangle's middle
        corners, shares = rng.normal(size=(3, 3)), rng.normal(size=3)
        start = shares @ corners / shares.sum()
        along = corners.mean(axis=0) - start
        mesh = TriangleMesh(corners, np.array([[0, 1, 2]]))
        assert np.isinf(cast_plain(mesh, start, along[None] / np.linalg.norm(along))[0][0])


def test_a_ray_does_not_hit_where_it_starts() -> None:
    box = block(LOW, HIGH)
    start = np.array([0.2, 0.1, HIGH[2]])
    ranges, _ = cast_plain(box, start, np.array([FORWARD, -FORWARD, [0.6, 0, -0.8]]))
    np.testing.assert_allclose(ranges, [np.inf, 0.8, 0.5], rtol=1e-12)


def test_no_rays_give_no_hits() -> None:
    for origins in (np.zeros(3), np.zeros((0, 3))):
        ranges, triangles = cast_plain(TRIANGLE, origins, np.zeros((0, 3)))
        assert ranges.shape == triangles.shape == (0,)


@pytest.mark.parametrize(
    ("origins", "directions"), [((3,), (3,)), ((2, 3), (3, 3)), ((1, 3), (3, 3)), ((3,), (2, 2)), ((2,), (2, 3))]
)
def test_shapes_that_do_not_fit_are_refused(origins: tuple[int, ...], directions: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="wanted"):
        cast_plain(TRIANGLE, np.zeros(origins), np.ones(directions))


def test_blocks_change_nothing() -> None:
    """More triangles and more rays than one block holds, against the rays one at a time."""
    mesh = bumpy_sphere(20, 30)
    directions = unit_rays(np.random.default_rng(3), 400)
    origin = np.array([0.1, -0.1, 0.7])
    ranges, triangles = cast_plain(mesh, origin, directions)
    alone = [cast_plain(mesh, origin, ray[None]) for ray in directions]
    np.testing.assert_array_equal(triangles, [hit[1][0] for hit in alone])
    np.testing.assert_array_equal(ranges, [hit[0][0] for hit in alone])
    again = cast_plain(mesh, np.tile(origin, (400, 1)), directions)
    np.testing.assert_array_equal(triangles, again[1])
    np.testing.assert_allclose(ranges, again[0], rtol=1e-12)  # the origin is subtracted in another order


@given(seed=SEEDS)
def test_moving_rays_and_mesh_together_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh, directions, origins = soup(rng), unit_rays(rng, 50), rng.normal(scale=0.3, size=(50, 3))
    motion = pose(rotation_from_rotvec(rng.normal(size=3)), rng.normal(scale=5, size=3))
    ranges, triangles = cast_plain(mesh, origins, directions)
    moved, same = cast_plain(mesh.moved(motion), transform(motion, origins), directions @ motion[:3, :3].T)
    agree = triangles == same  # a ray through an edge may go either way
    assert agree.mean() >= 0.98
    np.testing.assert_allclose(moved[agree], ranges[agree], rtol=1e-8)  # coordinates of 10 m, cosines down to 1e-6


def test_a_grazing_hit_stays_on_its_triangle() -> None:
    """Where float32 names a triangle that the exact ray just misses, its plane may be met anywhere: the corners hold it."""
    ray = np.array([[1.0, 0.0, 1e-12]])
    for height in (1.0 - 1e-7, 1.0, 1.0 + 1e-7):
        ranges = plane_ranges(TRIANGLE, face_planes(TRIANGLE), np.array([0], dtype=np.int32), np.array([-1.0, 0.2, height]), ray)
        assert 1 - 1e-9 <= ranges[0] <= 2 + 1e-9


def test_cosines_of_an_image_keep_its_shape() -> None:
    directions = np.tile(FORWARD, (4, 5, 1))
    triangles = np.where(np.arange(20).reshape(4, 5) % 2, 0, -1).astype(np.int32)
    np.testing.assert_array_equal(incidence_cosines(face_planes(TRIANGLE), triangles, directions), triangles + 1.0)

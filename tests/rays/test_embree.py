"""Casting through Embree: the triangle in float32, the range in float64."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.triangles import block, block_ranges, bumpy_sphere, first_hits, soup, unit_rays
from viewgain.errors import MissingExtraError
from viewgain.geometry import pose, rotation_from_rotvec, transform
from viewgain.meshes import TriangleMesh
from viewgain.rays._embree import EmbreeMesh
from viewgain.rays._triangles import cast_plain, incidence_cosines

pytest.importorskip("embreex", reason="embreex has no wheel for linux on aarch64")

SEEDS = st.integers(0, 2**32 - 1)
LOW, HIGH = np.array([-0.3, -0.2, 0.1]), np.array([0.5, 0.4, 0.9])
TRIANGLE = TriangleMesh(np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]]), np.array([[0, 1, 2]]))
FORWARD = np.array([0.0, 0.0, 1.0])


@given(seed=SEEDS, shared=st.booleans())
def test_a_soup_agrees_with_the_ray_by_ray_twin(seed: int, shared: bool) -> None:
    """Rays within 1e-6 m of an edge, or of a second surface, are left to rounding: fewer than one in twenty may be."""
    rng = np.random.default_rng(seed)
    mesh, directions = soup(rng), unit_rays(rng, 40)
    origins = rng.normal(scale=0.3, size=3) if shared else rng.normal(scale=0.3, size=(40, 3))
    embree = EmbreeMesh(mesh)
    ranges, triangles = embree.cast(origins, directions)
    expected, index, cosines, clear = first_hits(mesh, origins, directions)
    assert clear.mean() > 0.95
    np.testing.assert_array_equal(triangles[clear], index[clear])
    np.testing.assert_allclose(ranges[clear], expected[clear], rtol=1e-9)  # the range is float64's own
    np.testing.assert_allclose(incidence_cosines(embree.planes, triangles, directions)[clear], cosines[clear], atol=1e-12)


@pytest.mark.parametrize("away", [0.0, 10.0], ids=["near the origin", "17 m from it"])
@pytest.mark.parametrize("origin", [np.array([0.1, 0.05, -1.5]), np.array([0.1, 0.1, 0.5])], ids=["outside", "inside"])
def test_a_box_is_hit_where_its_slabs_say(away: float, origin: np.ndarray) -> None:
    directions = unit_rays(np.random.default_rng(1), 20000)
    ranges, triangles = EmbreeMesh(block(LOW + away, HIGH + away)).cast(origin + away, directions)
    expected = block_ranges(LOW + away, HIGH + away, origin + away, directions)
    assert np.mean(np.isfinite(ranges) != np.isfinite(expected)) < 1e-4  # the outline, to float32
    both = np.isfinite(ranges) & np.isfinite(expected)
    assert np.max(np.abs(ranges[both] - expected[both])) < 1e-6  # beside an edge the neighbour's plane is as good as that
    np.testing.assert_array_equal(triangles >= 0, np.isfinite(ranges))
    assert triangles.dtype == np.int32


def test_a_fine_mesh_agrees_with_the_plain_caster() -> None:
    mesh = bumpy_sphere(40, 50)
    rng = np.random.default_rng(4)
    origins = unit_rays(rng, 3000)
    directions = -origins + rng.normal(scale=0.2, size=(3000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    ranges, triangles = EmbreeMesh(mesh).cast(origins, directions)
    expected, index = cast_plain(mesh, origins, directions)
    assert np.mean(triangles != index) < 1e-3
    same = triangles == index
    np.testing.assert_array_equal(ranges[same], expected[same])  # one formula for both


def test_far_from_the_origin_nothing_is_lost() -> None:
    """A kilometre out float32 resolves 60 micrometres; the mesh does not notice."""
    mesh, away = bumpy_sphere(40, 50), np.array([700.0, -500.0, 300.0])
    directions = unit_rays(np.random.default_rng(7), 20000)
    ranges, triangles = EmbreeMesh(mesh).cast(np.zeros(3), directions)
    found, same = EmbreeMesh(mesh.moved(pose(np.eye(3), away))).cast(away, directions)
    assert np.mean(same != triangles) < 1e-4
    np.testing.assert_allclose(found, ranges, atol=1e-7)  # float64 at a kilometre, facets that lean, neighbours' planes


def test_both_sides_count_and_beside_is_a_miss() -> None:
    origins = np.array([[0.2, 0.2, 0.0], [0.2, 0.2, 3.0], [0.7, 0.7, 0.0], [0.2, 0.2, 0.0]])
    ranges, triangles = EmbreeMesh(TRIANGLE).cast(origins, np.array([FORWARD, -FORWARD, FORWARD, -FORWARD]))
    np.testing.assert_allclose(ranges, [1, 2, np.inf, np.inf], rtol=1e-15)
    np.testing.assert_array_equal(triangles, [0, 0, -1, -1])


def test_no_ray_slips_between_neighbours() -> None:
    """Through the middles of all edges, and within 1e-7 m of all corners. Exactly at a corner two rays in a thousand do slip."""
    mesh = bumpy_sphere(60, 80)
    beside = mesh.vertices + np.random.default_rng(8).normal(scale=1e-7, size=mesh.vertices.shape)
    for targets in ((mesh.triangles[:, 0] + mesh.triangles[:, 1]) / 2, beside):
        ranges, _ = EmbreeMesh(mesh).cast(np.zeros(3), targets / np.linalg.norm(targets, axis=1, keepdims=True))
        assert np.all(np.isfinite(ranges))


def test_rays_that_start_on_the_mesh_do_not_hit_where_they_start() -> None:
    """Second bounces: from points found on the mesh, inwards and outwards, against the plain caster."""
    mesh = bumpy_sphere(30, 40)
    rng = np.random.default_rng(5)
    away = unit_rays(rng, 2000)
    embree = EmbreeMesh(mesh)
    ranges, triangles = embree.cast(np.zeros(3), away)
    starts = ranges[:, None] * away
    directions = unit_rays(rng, 2000)
    steep = incidence_cosines(embree.planes, triangles, directions) > 0.01  # a grazing ray leaves its triangle too late
    found, hit = embree.cast(starts[steep], directions[steep])
    expected, index = cast_plain(mesh, starts[steep], directions[steep])
    assert found.min() > 1e-6
    assert np.mean(hit != index) < 2e-3
    np.testing.assert_allclose(found[hit == index], expected[hit == index], rtol=1e-9)


def test_a_ray_along_its_own_surface_ends() -> None:
    """It grazes the face it starts on at every angle down to none: whatever is found lies ahead, and the search ends."""
    angles = np.geomspace(1e-12, 0.5, 400)
    directions = np.stack([np.cos(angles), np.zeros(400), np.sin(angles)], axis=1)
    start = np.array([LOW[0], 0.1, HIGH[2]])
    for up in (1, -1):
        ranges, _ = EmbreeMesh(block(LOW, HIGH)).cast(start, directions * [1, 1, up])
        assert np.all(ranges > 1e-6)


def test_degenerate_triangles_and_vertices_of_none_are_left_out() -> None:
    vertices = np.vstack([[[np.nan, 0, 0], [1e300, 0, 0]], TRIANGLE.vertices])
    mesh = TriangleMesh(vertices, np.array([[2, 2, 2], [2, 3, 3], [2, 3, 4], [3, 4, 4], [4, 2, 3]]))
    directions = np.array([FORWARD, -FORWARD])
    ranges, triangles = EmbreeMesh(mesh).cast(np.array([0.2, 0.2, 0.0]), directions)
    assert triangles[0] in (2, 4)  # the same triangle twice: Embree does not say which
    np.testing.assert_array_equal(ranges, [1.0, np.inf])
    assert triangles[1] == -1


def test_a_ray_in_the_plane_of_a_triangle_misses_it() -> None:
    ranges, _ = EmbreeMesh(TRIANGLE).cast(np.array([-1.0, 0.2, 1.0]), np.array([[1.0, 0, 0], [0.6, 0.8, 0]]))
    assert np.all(np.isinf(ranges))


def test_no_rays_give_no_hits() -> None:
    for origins in (np.zeros(3), np.zeros((0, 3))):
        ranges, triangles = EmbreeMesh(TRIANGLE).cast(origins, np.zeros((0, 3)))
        assert ranges.shape == triangles.shape == (0,)


def test_shapes_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="wanted"):
        EmbreeMesh(TRIANGLE).cast(np.zeros((1, 3)), np.ones((2, 3)))


@given(seed=SEEDS)
def test_moving_rays_and_mesh_together_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh, directions, origins = soup(rng), unit_rays(rng, 50), rng.normal(scale=0.3, size=(50, 3))
    motion = pose(rotation_from_rotvec(rng.normal(size=3)), rng.normal(scale=5, size=3))
    ranges, triangles = EmbreeMesh(mesh).cast(origins, directions)
    moved, same = EmbreeMesh(mesh.moved(motion)).cast(transform(motion, origins), directions @ motion[:3, :3].T)
    agree = triangles == same  # a ray through an edge may go either way
    assert agree.mean() >= 0.98
    np.testing.assert_allclose(moved[agree], ranges[agree], rtol=1e-8)  # coordinates of 10 m, cosines down to 1e-6


def test_blocks_threads_and_repetition_change_nothing() -> None:
    embree = EmbreeMesh(bumpy_sphere(40, 50))
    directions = unit_rays(np.random.default_rng(6), 40000)
    ranges, triangles = embree.cast(np.zeros(3), directions)
    again = embree.cast(np.zeros((40000, 3)), directions)
    np.testing.assert_array_equal(again[1], triangles)
    with ThreadPoolExecutor(2) as pool:
        parts = list(pool.map(lambda part: embree.cast(np.zeros(3), part), np.array_split(directions, 7)))
    np.testing.assert_array_equal(np.concatenate([part[0] for part in parts]), ranges)
    np.testing.assert_array_equal(np.concatenate([part[1] for part in parts]), triangles)


def test_without_embreex_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex", None)
    for name in ("embreex.mesh_construction", "embreex.rtcore_scene"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    with pytest.raises(MissingExtraError, match=r"viewgain\[data\]"):
        EmbreeMesh(TRIANGLE)


def test_importing_the_casters_loads_no_library() -> None:
    code = """
import viewgain.rays._embree, viewgain.rays._triangles, viewgain.rays._zbuffer, sys
assert not {"numba", "embreex", "trimesh", "torch"} & set(sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr

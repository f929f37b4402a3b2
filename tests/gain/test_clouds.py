"""Surface samples and the clouds that views see of a mesh."""

import numpy as np
import pytest

from tests.oracles.triangles import block, bumpy_sphere
from viewgain.errors import ConfigError, MissingExtraError
from viewgain.gain import PCNBV, CoverageProtocol, _clouds, model_clouds, surface_samples
from viewgain.meshes import TriangleMesh
from viewgain.rays import SceneCaster
from viewgain.rigs import Target, poses, rig
from viewgain.scenes import Scene

SMALL = CoverageProtocol(name="small", rig="pcnbv33", steps=1, width=64, height=48, focal=47.6)


def test_samples_are_uniform_in_area() -> None:
    # Two triangles of areas 0.5 and 2, at z = 0 and z = 1.
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 1], [0, 2, 1]], dtype=float)
    mesh = TriangleMesh(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
    points = surface_samples(mesh, 20000, rng=np.random.default_rng(0))
    upper = points[:, 2] > 0.5
    assert upper.mean() == pytest.approx(0.8, abs=0.015)  # five standard deviations
    np.testing.assert_allclose(points[:, 2], upper, rtol=1e-15)
    assert np.all(points[:, :2] >= 0)
    assert np.all(points[:, :2].sum(axis=1) <= np.where(upper, 2, 1) + 1e-12)
    np.testing.assert_allclose(points[upper, :2].mean(axis=0), 2 / 3, atol=0.02)  # the centroid
    quarter = np.mean(points[upper, :2].sum(axis=1) < 1)  # the corner half as long has a quarter of the area
    assert quarter == pytest.approx(0.25, abs=0.02)


def test_samples_come_back_with_the_seed_and_none_are_fine() -> None:
    mesh = block(np.zeros(3), np.array([1.0, 2.0, 3.0]))
    first, second = (surface_samples(mesh, 50, rng=np.random.default_rng(7)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert surface_samples(mesh, 0, rng=np.random.default_rng(7)).shape == (0, 3)
    with pytest.raises(ConfigError, match="wanted"):
        surface_samples(mesh, -1, rng=np.random.default_rng(7))


def test_every_view_sees_the_side_that_faces_it() -> None:
    clouds = model_clouds(block(np.zeros(3), np.ones(3)), SMALL)
    half = 0.5 / np.sqrt(3)  # of a cube whose diagonal is 1
    views = poses(rig("pcnbv33"), Target.at(np.zeros(3)), distance=1.0)
    assert len(clouds) == 33
    np.testing.assert_allclose(np.linalg.norm(views[:, :3, 3], axis=1), 1.0)
    for cloud, view in zip(clouds, views, strict=True):
        np.testing.assert_allclose(np.abs(cloud).max(axis=1), half, atol=1e-12)  # on the surface
        face = np.argmax(np.abs(cloud), axis=1)
        outward = np.sign(cloud[np.arange(len(cloud)), face])
        assert np.all(outward * view[face, 3] > half)  # only faces whose front the camera is on
    assert np.all(clouds[0][:, 2] == pytest.approx(half))  # the pole sees the top only


def test_without_the_extra_rays_are_cast(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = bumpy_sphere(8, 10)
    drawn = model_clouds(mesh, SMALL)

    def missing(*_: object) -> None:
        raise MissingExtraError("no numba")

    def plainly(scene: Scene) -> SceneCaster:
        return SceneCaster(scene, backend="plain")

    monkeypatch.setattr(_clouds, "zbuffer", missing)
    monkeypatch.setattr(_clouds, "SceneCaster", plainly)
    for a, b in zip(drawn, model_clouds(mesh, SMALL), strict=True):
        assert a.shape == b.shape
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_scale_and_place_of_the_mesh_do_not_count() -> None:
    mesh = bumpy_sphere(10)
    moved = TriangleMesh(mesh.vertices * 40 + [3, -2, 9], mesh.faces)
    for a, b in zip(model_clouds(mesh, SMALL), model_clouds(moved, SMALL), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_full_size_images_hold_the_whole_object() -> None:
    for cloud in model_clouds(bumpy_sphere(10), PCNBV)[::8]:
        assert len(cloud) > 10_000
        extent = np.ptp(cloud, axis=0)
        assert np.linalg.norm(extent) < 1.0

"""One interface to scenes: every backend sees the same, a box is its mesh, and rendering commutes with rigid motion."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.shapes import box_mesh
from viewgain.camera import Intrinsics
from viewgain.errors import MissingExtraError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.meshes import TriangleMesh
from viewgain.rays import NOTHING, Backend, SceneCaster, pixel_rays, rays_through
from viewgain.scenes import FLOOR, Scene, orbit_pose, standing_box, wall

CAMERA = Intrinsics.from_field_of_view(64, 48, *np.deg2rad([62.0, 45.0]))
BOX = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4)
VIEW = orbit_pose(BOX.centre, 0.7, 0.7, 1.2)
BACKENDS: tuple[Backend, ...] = ("zbuffer", "embree", "plain", "auto")


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("azimuth", [0.1, 2.0, 4.4])
def test_a_box_equals_its_mesh_to_1e_5_m(backend: Backend, azimuth: float) -> None:
    """The depth of the analytic box against each way of hitting its twelve triangles; edges may round to either side."""
    view = orbit_pose(BOX.centre, azimuth, 0.6, 1.1)
    exact = SceneCaster(Scene((BOX,))).pixels(CAMERA, view)
    found = SceneCaster(Scene(meshes=(box_mesh(BOX),)), backend=backend).pixels(CAMERA, view)
    apart = np.abs(exact.ranges - found.ranges) > 1e-5
    assert apart.mean() < 0.001
    np.testing.assert_allclose(found.cosine[~apart], exact.cosine[~apart], atol=1e-4)


@settings(max_examples=15)
@given(st.tuples(*[st.floats(-3, 3)] * 6))
def test_rendering_commutes_with_rigid_motion(motion: tuple[float, ...]) -> None:
    """Any motion, tilts included: floor and walls are planes like others. Edges may round to either side."""
    move = pose(rotation_from_rotvec(np.array(motion[:3])), np.array(motion[3:]))
    scene = Scene((BOX,), (box_mesh(standing_box(np.array([0.1, 0.1, 0.3]), at=(0.4, 0.0))),), (FLOOR, wall(3.6, 1.0)))
    here, there = SceneCaster(scene).pixels(CAMERA, VIEW), SceneCaster(scene.moved(move)).pixels(CAMERA, move @ VIEW)
    apart = here.surfaces != there.surfaces
    assert apart.mean() < 0.003
    np.testing.assert_allclose(there.ranges[~apart], here.ranges[~apart], rtol=1e-8)


def test_surfaces_say_what_was_hit_in_the_order_boxes_meshes_planes() -> None:
    mesh = box_mesh(standing_box(np.array([0.1, 0.1, 0.3]), at=(0.4, 0.3)))
    caster = SceneCaster(Scene((BOX,), (mesh,), (FLOOR, wall(3.8, 0.9)), (0.9, 0.2, 0.4, 0.6)))
    hits, surfaces = caster.pixels(CAMERA, VIEW), caster.surfaces
    assert len(surfaces) == 6 + len(mesh.faces) + 2
    found = set(np.round(surfaces.reflectivity[hits.surfaces[hits.surfaces != NOTHING]], 6))
    assert found == {0.9, 0.2, 0.4, 0.6}
    assert set(surfaces.patches[hits.surfaces]) >= {6, 7, 8}  # the mesh, the floor, the wall are one patch each
    normals = surfaces.normals[hits.surfaces] @ VIEW[:3, :3]
    cosine = np.abs(sum(normals[:, k] * pixel_rays(CAMERA)[k] for k in range(3)))
    np.testing.assert_allclose(hits.cosine, cosine, atol=1e-9)


def test_nothing_is_met_in_an_empty_world() -> None:
    hits = SceneCaster(Scene(planes=())).pixels(CAMERA, VIEW)
    assert np.isinf(hits.ranges).all()
    assert (hits.surfaces == NOTHING).all()
    assert SceneCaster(Scene(planes=())).surfaces.reflectivity[hits.surfaces].max() == 0


def test_rays_through_the_pixel_centres_see_what_the_pixels_see() -> None:
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].reshape(2, -1)
    for scene in (Scene((BOX,)), Scene(meshes=(box_mesh(BOX),))):
        caster = SceneCaster(scene)
        image, rays = caster.pixels(CAMERA, VIEW), caster.rays(VIEW, rays_through(CAMERA, np.stack([u, v], axis=-1)))
        apart = np.abs(image.ranges - rays.ranges) > 1e-9
        assert apart.mean() < 0.002


def test_a_lens_with_distortion_is_cast_ray_by_ray() -> None:
    lens = Intrinsics(width=64, height=48, fx=55, fy=55, cx=31.5, cy=23.5, distortion=(-0.2, 0.05, 0.0, 0.0))
    exact = SceneCaster(Scene((BOX,))).pixels(lens, VIEW)
    found = SceneCaster(Scene(meshes=(box_mesh(BOX),))).pixels(lens, VIEW)
    assert np.mean(np.abs(exact.ranges - found.ranges) > 1e-5) < 0.002


def test_several_meshes_are_one_to_the_rays_and_apart_to_their_surfaces() -> None:
    pair = (box_mesh(standing_box(np.array([0.2, 0.2, 0.2]), at=(0.2, 0.0))), box_mesh(standing_box(np.array([0.2, 0.2, 0.4]))))
    hits = SceneCaster(Scene(meshes=pair)).pixels(CAMERA, VIEW)
    boxes = (standing_box(np.array([0.2, 0.2, 0.2]), at=(0.2, 0.0)), standing_box(np.array([0.2, 0.2, 0.4])))
    expected = SceneCaster(Scene(boxes)).pixels(CAMERA, VIEW)
    assert np.mean(np.abs(hits.ranges - expected.ranges) > 1e-5) < 0.002


def test_without_the_extra_auto_falls_back_and_a_named_backend_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene(meshes=(box_mesh(BOX),))
    expected = SceneCaster(scene, backend="plain").pixels(CAMERA, VIEW)
    for package in ("numba", "embreex", "embreex.mesh_construction", "embreex.rtcore_scene"):
        monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.setattr("viewgain.rays._caster.find_spec", lambda name: None)
    np.testing.assert_array_equal(SceneCaster(scene).pixels(CAMERA, VIEW).ranges, expected.ranges)
    with pytest.raises(MissingExtraError, match="viewgain\\[data\\]"):
        SceneCaster(scene, backend="embree").pixels(CAMERA, VIEW)


def test_a_mesh_without_thickness_is_seen_from_both_sides() -> None:
    sheet = TriangleMesh(np.array([[-1, -1, 0.5], [1, -1, 0.5], [1, 1, 0.5], [-1, 1, 0.5]]), np.array([[0, 1, 2], [0, 2, 3]]))
    for elevation in (0.6, -0.6):
        hits = SceneCaster(Scene(meshes=(sheet,), planes=())).pixels(
            CAMERA, orbit_pose(np.array([0, 0, 0.5]), 0.2, elevation, 0.8)
        )
        assert np.isfinite(hits.ranges).mean() > 0.5

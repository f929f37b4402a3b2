"""The page that tells the method: exact without noise, repeatable with it, and blind to where in the world all this happens."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from tests.oracles.rays import world_range
from tests.oracles.scenes import corner_view
from tests.oracles.triangles import block, first_hits
from tests.simulate.targets import EYE, FAR, MOTIONS, PICO, SMALL, Array, cropped, flat_target, only_plane, plate, ranges_of
from viewgain.box import Box
from viewgain.camera import Intrinsics, sensor
from viewgain.errors import ConfigError, ScanError
from viewgain.rays import SceneCaster
from viewgain.scenes import FLOOR, Scene, orbit_pose, standing_box, wall
from viewgain.simulate import EFFECTS, Effects, RangeError, capture, true_hits

BOX = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)
VIEW = corner_view(BOX)
BLOCK = block(np.array([0.5, -0.2, 0.0]), np.array([0.7, 0.1, 0.25]))
ALL_KINDS = Scene((BOX,), (BLOCK,), (FLOOR, wall(np.deg2rad(230), 0.8)), (0.6, 0.3, 0.5, 0.8))
"""A box, a mesh, floor and wall, all of different brightness."""
BUSY = replace(SMALL, jitter_px=0.2, flying_filter=0.05, unambiguous=1.3, lateral_px=0.5)
"""Every effect bites, but no rounding: a step would blow a difference of 1e-16 up to a whole quantum."""


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("generator", [None, 5])
@settings(max_examples=8)
@given(
    st.lists(st.floats(0.1, 0.5), min_size=6, max_size=6),
    st.floats(0, 6.2),
    st.floats(20, 75),
    st.floats(0.9, 1.8),
    st.floats(-0.5, 0.5),
)
def test_a_perfect_camera_reports_what_the_oracle_finds(
    generator: int | None, extents: list[float], azimuth: float, elevation: float, distance: float, roll: float
) -> None:
    """Two boxes, one perhaps before the other; a pixel that a nudge of 1e-7 takes to another surface is left to rounding."""
    boxes = (standing_box(np.array(extents[:3]), yaw=0.3), standing_box(np.array(extents[3:]), yaw=1.0, at=(0.55, 0.2)))
    view = orbit_pose(np.array([0.2, 0.1, 0.1]), azimuth, np.deg2rad(elevation), distance, roll)
    camera = replace(SMALL, range_max=1e3)
    chance = None if generator is None else rng(generator)
    effects = None if generator is None else Effects.only()
    scan = capture(Scene(boxes), view, camera, rng=chance, effects=effects)
    found = np.nan_to_num(ranges_of(scan).ravel(), nan=np.inf)
    for ray, measured in zip(camera.intrinsics.directions().reshape(-1, 3), found, strict=True):
        true, _ = world_range(boxes, view, ray)
        true = true if true <= camera.range_max else np.inf
        if not np.isclose(measured, true, rtol=1e-9):
            nudges = np.array([(1e-7, 0, 0), (-1e-7, 0, 0), (0, 1e-7, 0), (0, -1e-7, 0)])
            beside = [world_range(boxes, view, ray + nudge)[0] for nudge in nudges]
            assert np.ptp(np.minimum(beside, 1e6)) > 1e-4, (ray, measured, true)


@settings(max_examples=10)
@given(st.floats(0, 6.2), st.floats(20, 85), st.floats(0.9, 1.8))
def test_the_true_hits_are_the_oracles(azimuth: float, elevation: float, distance: float) -> None:
    """Ranges and cosines, and the name of the surface through the normals; rounding only, hence 1e-9."""
    scene, view = Scene((BOX,)), orbit_pose(BOX.centre, azimuth, np.deg2rad(elevation), distance)
    hits = true_hits(scene, view, SMALL)
    normals = SceneCaster(scene).surfaces.normals_of(hits.surfaces)
    for k, ray in list(enumerate(SMALL.intrinsics.directions().reshape(-1, 3)))[::17]:
        true, cosine = world_range(scene.boxes, view, ray)
        if np.isclose(true, hits.ranges[k], rtol=1e-6):  # else the ray meets an edge
            np.testing.assert_allclose(hits.ranges[k], true, rtol=1e-9)
            np.testing.assert_allclose(hits.cosine[k], cosine, atol=1e-9)
            np.testing.assert_allclose(abs(normals[k] @ view[:3, :3] @ ray), cosine, atol=1e-9)


def test_a_perfect_camera_sees_meshes_as_the_oracle_does() -> None:
    """1e-9: the range comes from the triangle's plane in float64, whatever found the triangle."""
    view = orbit_pose(np.array([0.6, 0.0, 0.1]), 0.7, np.deg2rad(35), 0.5)
    found = ranges_of(capture(Scene(meshes=(BLOCK,), planes=()), view, SMALL, rng=None)).ravel()
    rays = SMALL.intrinsics.directions().reshape(-1, 3) @ view[:3, :3].T
    true, _, _, clear = first_hits(BLOCK, view[:3, 3], rays)
    assert 100 < np.isfinite(true).sum() < 500
    np.testing.assert_allclose(np.nan_to_num(found, nan=np.inf)[clear], true[clear], rtol=1e-9)


@pytest.mark.parametrize("backend", ["plain", "embree", "zbuffer"])
def test_every_way_to_hit_a_mesh_gives_the_same_image(backend: str) -> None:
    """With all effects: each sub-ray's range is taken from the plane it hits, so a few 1e-12 remain (times the noise's slope)."""
    expected = ranges_of(capture(ALL_KINDS, VIEW, BUSY, rng=rng()))
    found = ranges_of(capture(SceneCaster(ALL_KINDS, backend=backend), VIEW, BUSY, rng=rng()))  # type: ignore[arg-type]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@settings(max_examples=8)
@given(MOTIONS)
def test_moving_scene_and_camera_together_changes_no_pixel_of_a_perfect_camera(motion: Array) -> None:
    still = capture(ALL_KINDS, VIEW, SMALL, rng=None)
    moved = capture(ALL_KINDS.moved(motion), motion @ VIEW, SMALL, rng=None)
    np.testing.assert_allclose(ranges_of(moved), ranges_of(still), atol=1e-9)
    np.testing.assert_allclose(moved.amplitude, still.amplitude, atol=1e-9)


@settings(max_examples=8)
@given(MOTIONS)
def test_moving_scene_and_camera_together_changes_no_pixel_of_a_real_one(motion: Array) -> None:
    """All effects, same seed. 1e-6 m: the bounced light is interpolated in float32, 1e-7 of bends of centimetres."""
    still = capture(ALL_KINDS, VIEW, BUSY, rng=rng(4))
    moved = capture(ALL_KINDS.moved(motion), motion @ VIEW, BUSY, rng=rng(4))
    np.testing.assert_allclose(ranges_of(moved), ranges_of(still), atol=1e-6)
    np.testing.assert_allclose(moved.amplitude, still.amplitude, atol=1e-6)


def test_the_same_seed_gives_the_same_bits_and_another_seed_others() -> None:
    first, again, other = (capture(ALL_KINDS, VIEW, PICO, rng=rng(seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.organised(), again.organised())
    np.testing.assert_array_equal(first.amplitude, again.amplitude)
    both = np.isfinite(ranges_of(first)) & np.isfinite(ranges_of(other))
    assert np.mean(ranges_of(first)[both] != ranges_of(other)[both]) > 0.99


def test_a_generator_that_is_used_again_gives_another_scan() -> None:
    chance = rng()
    first, second = (capture(Scene((BOX,)), VIEW, SMALL, rng=chance) for _ in range(2))
    assert np.mean(ranges_of(first) != ranges_of(second)) > 0.9


@pytest.mark.parametrize("name", ["loss", "filtering"])
def test_what_survives_a_loss_is_the_same_to_the_bit_without_it(name: str) -> None:
    """Both only take pixels away, and their draws are their own."""
    camera = replace(BUSY, grazing_start=np.deg2rad(30), grazing_end=np.deg2rad(80))
    with_it, without = (
        ranges_of(capture(ALL_KINDS, VIEW, camera, rng=rng(), effects=e)) for e in (Effects(), Effects().without(name))
    )
    if name == "filtering":
        lost = np.isnan(with_it) & np.isfinite(without)
        assert 0 < lost.sum() < 100
    else:
        # The filter looks at neighbours, which losses take away; so it is off here.
        with_it = ranges_of(capture(ALL_KINDS, VIEW, camera, rng=rng(), effects=Effects().without("filtering")))
        without = ranges_of(capture(ALL_KINDS, VIEW, camera, rng=rng(), effects=Effects().without("filtering", "loss")))
        assert np.isnan(with_it).sum() > np.isnan(without).sum() + 30
    survivors = np.isfinite(with_it)
    np.testing.assert_array_equal(with_it[survivors], without[survivors])


@pytest.mark.parametrize("name", ["noise", "multipath", "wiggle"])
def test_the_same_pixels_are_lost_whatever_else_is_on(name: str) -> None:
    """Bounced light strengthens a return, so no loss to weakness here; what is lost hangs on incidence and the draws alone."""
    camera = replace(FAR, intrinsics=SMALL.intrinsics, grazing_start=np.deg2rad(30), grazing_end=np.deg2rad(80))
    lost = [
        np.isnan(ranges_of(capture(ALL_KINDS, VIEW, camera, rng=rng(), effects=e))) for e in (Effects(), Effects().without(name))
    ]
    assert 30 < lost[0].sum() < 500
    np.testing.assert_array_equal(*lost)


def test_the_noise_is_the_same_whatever_else_is_on() -> None:
    """Noise is added to what the other effects made: the difference to the image without noise is the same, to rounding."""
    differences = []
    for others in ((), ("multipath",), ("multipath", "wiggle")):
        images = [
            ranges_of(
                capture(Scene((BOX,)), VIEW, replace(FAR, intrinsics=SMALL.intrinsics), rng=rng(), effects=Effects.only(*names))
            )
            for names in (others, ("noise", *others))
        ]
        differences.append(images[1] - images[0])
    # Only as large as what the noise depends on: the range, which a bend of centimetres changes by some per cent.
    np.testing.assert_allclose(differences[1], differences[0], rtol=0.1, atol=1e-12)
    np.testing.assert_allclose(differences[2], differences[1], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("lateral_px", [1.0, 0.5])
def test_switching_mixing_leaves_the_displacements_of_edges_as_they_are(lateral_px: float) -> None:
    """A pattern locks to the surface that fills most of a footprint: on a straight edge the one at its middle, mixing or not.

    0.2 % of the image: those second pixels flip with mixing only, and the plate's own thickness is a third surface.
    """
    camera = replace(cropped(sensor("kinect_v2"), 41, 201), kind="structured_light", lateral_px=lateral_px)
    scene = Scene((plate(1.0, roll=0.03),), planes=(flat_target(2.0),))
    still, shaken, mixed = (
        ranges_of(capture(scene, EYE, camera, rng=rng(), effects=Effects.only(*names))) < 1.5
        for names in ((), ("lateral",), ("lateral", "mixing"))
    )
    if np.mean(still != shaken) < 0.005:
        pytest.fail("the displacements do not show")
    assert np.mean(shaken != mixed) < 2e-3


@pytest.mark.parametrize("frames", [4, 16])
def test_averaging_frames_divides_the_noise_by_the_root_of_their_number(frames: int) -> None:
    """2 %: four standard errors of the spread of 38,304 residuals."""
    scene, camera = only_plane(flat_target(1.5)), FAR
    true = ranges_of(capture(scene, EYE, camera, rng=None))
    residual = ranges_of(capture(scene, EYE, camera, rng=rng(), effects=Effects.only("noise"), frames=frames)) - true
    sigma = camera.range_sigma(true, true**-1 * 1.5)
    np.testing.assert_allclose(np.std(residual / sigma), frames**-0.5, rtol=0.02)
    assert abs(np.mean(residual / sigma)) < 4 * (frames * residual.size) ** -0.5


def test_the_amplitude_is_averaged_too() -> None:
    scene = only_plane(flat_target(1.5))
    noise = []
    for frames in (1, 16):
        amplitude = capture(scene, EYE, FAR, rng=rng(), effects=Effects.only("noise"), frames=frames).amplitude
        assert amplitude is not None
        noise.append(np.std(amplitude - np.asarray(capture(scene, EYE, FAR, rng=None).amplitude)))
    np.testing.assert_allclose(noise[1] / noise[0], 0.25, rtol=0.03)  # 38,304 pixels each: 0.5 % in the ratio, times four


@pytest.mark.parametrize("frames", [4, 5])
def test_a_pixel_needs_half_of_the_frames(frames: int) -> None:
    """Frames are lost independently, so the share that remains is a binomial tail; and what remains is the exact range."""
    camera = replace(FAR, grazing_start=np.deg2rad(20), grazing_end=np.deg2rad(80))
    scene = only_plane(flat_target(1.5, np.deg2rad(55)))
    image = ranges_of(capture(scene, EYE, camera, rng=rng(), effects=Effects.only("loss"), frames=frames))
    hits = true_hits(scene, EYE, camera)
    expected = stats.binom.sf(np.ceil(frames / 2) - 1, frames, 1 - camera.loss(hits.cosine))
    kept = np.isfinite(image).ravel()
    assert abs(kept.mean() - expected.mean()) < 4 * np.sqrt(np.mean(expected * (1 - expected)) / kept.size)
    np.testing.assert_allclose(image.ravel()[kept], hits.ranges[kept], rtol=1e-12)


def test_returns_out_of_range_are_dropped() -> None:
    view = orbit_pose(np.zeros(3), 0.0, np.deg2rad(40), 1.5)
    everything = ranges_of(capture(Scene(), view, FAR, rng=None))
    limited = ranges_of(capture(Scene(), view, replace(FAR, range_min=1.2, range_max=1.9), rng=None))
    within = (everything >= 1.2) & (everything <= 1.9)
    assert 0.1 < within.mean() < 0.9
    np.testing.assert_array_equal(np.isfinite(limited), within)
    noisy = ranges_of(capture(Scene(), view, replace(PICO, range_min=1.2, range_max=1.9), rng=rng()))
    assert np.nanmin(noisy) >= 1.2
    assert np.nanmax(noisy) <= 1.9


@settings(max_examples=15)
@given(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02))
def test_a_miscalibrated_camera_reports_scaled_and_shifted_ranges(scale: float, offset: float) -> None:
    """Along the same ray, r (1 + s) + o, also for the camera that is perfect otherwise."""
    true = ranges_of(capture(Scene((BOX,)), VIEW, FAR, rng=None))
    wrong = capture(Scene((BOX,)), VIEW, FAR, rng=None, error=RangeError(scale, offset))
    np.testing.assert_allclose(ranges_of(wrong), true * (1 + scale) + offset, rtol=1e-12)
    directions = wrong.points / np.linalg.norm(wrong.points, axis=1, keepdims=True)
    np.testing.assert_allclose(directions, FAR.intrinsics.directions().reshape(-1, 3)[wrong.pixels], atol=1e-12)


def test_a_miscalibrated_camera_has_the_same_noise() -> None:
    """The draws and their size belong to the true range, so the difference is the systematic error alone."""
    images = [
        ranges_of(capture(Scene((BOX,)), VIEW, FAR, rng=rng(), effects=Effects.only("noise"), error=error))
        for error in (RangeError(), RangeError(0.01, 0.005))
    ]
    true = ranges_of(capture(Scene((BOX,)), VIEW, FAR, rng=None))
    np.testing.assert_allclose(images[1] - images[0], 0.01 * true + 0.005, atol=1e-12)


def test_the_amplitude_of_a_perfect_camera_is_lamberts() -> None:
    """Reflectivity cos / r^2, of each body its own; 0 where there is nothing, and for a white wall at 1 m head-on, 1."""
    scene = Scene((BOX,), (BLOCK,), (FLOOR,), (0.6, 0.3, 0.9))
    view = orbit_pose(BOX.centre, 0.5, np.deg2rad(12), 1.2)
    scan = capture(scene, view, FAR, rng=None)
    hits = true_hits(scene, view, FAR)
    reflectivity = np.array([0.6] * 6 + [0.3] * 12 + [0.9] + [0.0])[hits.surfaces]
    assert set(reflectivity) == {0.6, 0.3, 0.9, 0.0}
    seen = np.isfinite(hits.ranges)
    expected = np.zeros(len(seen))
    expected[seen] = reflectivity[seen] * hits.cosine[seen] / hits.ranges[seen] ** 2
    assert scan.amplitude is not None
    np.testing.assert_allclose(scan.amplitude.ravel(), expected, rtol=1e-12)
    white = capture(only_plane(flat_target(1.0), 1.0), EYE, cropped(FAR, 11, 11), rng=None).amplitude
    assert white is not None
    np.testing.assert_allclose(white[5, 5], 1.0, rtol=1e-12)


def test_a_scan_carries_its_camera_its_pose_its_amplitude_and_its_name() -> None:
    scan = capture(Scene((BOX,)), VIEW, PICO, rng=rng(), source="kitchen")
    assert scan.source == "kitchen"
    assert scan.intrinsics == PICO.intrinsics
    assert scan.shape == (171, 224)
    assert scan.amplitude is not None
    assert scan.amplitude.shape == (171, 224)
    assert scan.camera_to_world is not None
    np.testing.assert_allclose(scan.camera_to_world, VIEW, atol=1e-12)
    assert capture(Scene((BOX,)), VIEW, PICO, rng=None).source == "simulated"


@pytest.mark.parametrize("generator", [None, 0])
def test_a_camera_that_sees_nothing_says_so(generator: int | None) -> None:
    up = orbit_pose(np.array([0.0, 0.0, 3.0]), 0.0, np.deg2rad(-80), 1.5)  # looks at the sky
    with pytest.raises(ScanError, match="0 valid points"):
        capture(Scene(), up, PICO, rng=None if generator is None else rng(generator))


@pytest.mark.parametrize("elevation_deg", [85, 60, 35])
@pytest.mark.parametrize(
    "change", [{}, {"noise_constant": 0.004, "noise_per_metre": 0.0}, {"jitter_px": 1.5}, {"noise_per_square_metre": 0.01}]
)
def test_the_noise_on_a_floor_is_the_sensors(change: dict[str, float], elevation_deg: float) -> None:
    """Standardised by range_sigma, the residuals of 38,304 pixels have spread one (standard error 0.4 %).

    The slope term takes every pixel for one at the centre of the image; 12 degrees off axis that is 4 % too wide, so the camera
    is narrow, and has the same pitch both ways.
    """
    narrow = Intrinsics(width=224, height=171, fx=500.0, fy=500.0, cx=111.5, cy=85.0)
    camera = replace(FAR, intrinsics=narrow, wiggle=0.0, **change)
    view = orbit_pose(np.zeros(3), 0.3, np.deg2rad(elevation_deg), 1.5)
    measured = ranges_of(capture(Scene(), view, camera, rng=rng(5))).ravel()
    hits = true_hits(Scene(), view, camera)
    z = (measured - hits.ranges) / camera.range_sigma(hits.ranges, hits.cosine)
    assert np.isfinite(z).mean() > 0.99
    np.testing.assert_allclose(np.nanstd(z), 1, atol=0.04)
    assert abs(np.nanmean(z)) < 0.03  # 0.005 by chance; the rest is the bend of the range over a jitter on a slope


def test_jitter_alone_shows_on_slopes_as_large_as_asked_for_and_not_head_on() -> None:
    """Where a pixel looks moves the range by its angle times r tan(t): 1 % by chance, 2 % for the image's corners."""
    narrow = Intrinsics(width=224, height=171, fx=2000.0, fy=2000.0, cx=111.5, cy=85.0)
    camera = replace(FAR, intrinsics=narrow, jitter_px=0.7)
    jitter = Effects.only("jitter")
    slope = only_plane(flat_target(1.0, np.deg2rad(50)))
    true = true_hits(slope, EYE, camera)
    residual = ranges_of(capture(slope, EYE, camera, rng=rng(), effects=jitter)).ravel() - true.ranges
    tangent = np.sqrt(1 / true.cosine**2 - 1)
    np.testing.assert_allclose(np.std(residual / (true.ranges * tangent / 2000.0)), 0.7, rtol=0.03)
    head_on = only_plane(flat_target(1.0))
    residual = (
        ranges_of(capture(head_on, EYE, camera, rng=rng(), effects=jitter)).ravel() - true_hits(head_on, EYE, camera).ranges
    )
    assert np.abs(residual).max() < 1e-4  # 5 sd of 0.7 pixels of half a milliradian at up to 4 degrees off axis


def test_frames_share_the_jitter_of_their_scan() -> None:
    """It is one draw per pixel and scan, so averaging does not take it away."""
    camera, slope = replace(SMALL, jitter_px=0.7, range_max=1e3), only_plane(flat_target(1.0, np.deg2rad(40)))
    one, many = (ranges_of(capture(slope, EYE, camera, rng=rng(), effects=Effects.only("jitter"), frames=n)) for n in (1, 6))
    np.testing.assert_allclose(many, one, rtol=1e-12)


@pytest.mark.parametrize("scene", [Scene((BOX,)), ALL_KINDS])
def test_a_caster_gives_the_same_bits_as_its_scene_from_every_pose(scene: Scene) -> None:
    caster = SceneCaster(scene)
    for azimuth in (0.0, 1.1, 2.2):
        view = orbit_pose(BOX.centre, azimuth, 0.6, 1.2)
        fresh, prepared = (capture(each, view, PICO, rng=rng()) for each in (scene, caster))
        np.testing.assert_array_equal(prepared.organised(), fresh.organised())
        np.testing.assert_array_equal(prepared.amplitude, fresh.amplitude)
        np.testing.assert_array_equal(true_hits(caster, view, PICO).ranges, true_hits(scene, view, PICO).ranges)


@settings(max_examples=10)
@given(st.sets(st.sampled_from(EFFECTS)), st.floats(0, 6.2))
def test_a_mesh_box_looks_like_an_analytic_one(names: set[str], azimuth: float) -> None:
    """97 % of the pixels, to 1e-9; creases of a mesh are no edges to it. Bounced light is compared in test_multipath.py."""
    low, high = np.array([-0.2, -0.15, 0.0]), np.array([0.2, 0.15, 0.3])
    effects = Effects.only(*(names - {"multipath", "lateral"}))
    view = orbit_pose(np.array([0.0, 0.0, 0.15]), azimuth, 0.6, 1.2)
    solid = Scene((Box(EYE, high - low),))
    mesh = Scene(meshes=(block(low, high),))
    camera = replace(FAR, intrinsics=Intrinsics.from_field_of_view(80, 60, *np.deg2rad([62.0, 45.0])), flying_filter=0.05)
    images = [np.nan_to_num(ranges_of(capture(scene, view, camera, rng=rng(), effects=effects))) for scene in (solid, mesh)]
    assert np.mean(np.isclose(*images, atol=1e-9)) > 0.97


def test_no_frames_are_refused_in_words() -> None:
    for frames in (0, -1):
        with pytest.raises(ConfigError, match=f"{frames} frames"):
            capture(Scene((BOX,)), VIEW, SMALL, rng=None, frames=frames)

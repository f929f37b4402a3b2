"""The terms of a time-of-flight camera: known answers, an independent count of pixels, and their place in a choice."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.box import constraints
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.gain import (
    BorderTerm,
    BoxViews,
    Choice,
    ErrorHistogram,
    IncidenceTerm,
    NearZero,
    ProbabilityWithin,
    ScannedBox,
    WithTerms,
)
from viewgain.geometry import inverse
from viewgain.rays import SceneCaster
from viewgain.rigs import Target, poses, rig
from viewgain.scenes import Scene, orbit_pose, standing_box

CAMERA = Intrinsics.from_field_of_view(120, 90, *np.deg2rad([60.0, 46.0]))
BOX = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4)


def views(*cameras: np.ndarray) -> BoxViews:
    return BoxViews(BOX, np.stack(cameras), CAMERA)


def overhead(height: float) -> np.ndarray:
    return orbit_pose(np.array([0.0, 0.0, 0.2]), 0.3, np.pi / 2 - 1e-6, height)


@given(azimuth=st.floats(0, 6.28), elevation=st.floats(0.1, 1.5), distance=st.floats(0.6, 2.0))
def test_pixels_of_faces_are_those_of_the_simulator(azimuth: float, elevation: float, distance: float) -> None:
    camera = orbit_pose(BOX.centre, azimuth, elevation, distance)
    hits = SceneCaster(Scene((BOX,), planes=())).pixels(CAMERA, camera)
    # The slab test of the simulator is other code; its faces come in the same order, with the bottom last.
    twin = np.bincount(hits.surfaces[hits.surfaces >= 0], minlength=6)
    pixels = views(camera).face_pixels()[0]
    # Faces under a degree of grazing are passed by in one of them.
    assert np.abs(pixels - twin[:5]).sum() <= 4 + 0.02 * twin.sum()
    angles = constraints(BOX.in_frame(inverse(camera)), views(camera)._to_pixels, (120, 90)).incidence
    assert IncidenceTerm().gains(views(camera))[0] == pytest.approx(
        sum(n * np.cos(a) for n, a in zip(pixels, angles, strict=True) if n) / pixels.sum()
    )


def test_straight_above_the_top_is_square_and_grazing_is_not() -> None:
    above = views(overhead(1.5))
    assert IncidenceTerm().gains(above)[0] == pytest.approx(1, abs=1e-9)
    assert IncidenceTerm("linear").gains(above)[0] == pytest.approx(1, abs=1e-5)
    assert IncidenceTerm().name == "incidence_cosine"
    elevations = [orbit_pose(BOX.centre, 0.4, e, 3.0) for e in (1.55, 1.2, 0.9)]  # the top, ever more from the side
    terms = IncidenceTerm().gains(views(*elevations))
    assert terms[0] > terms[1] > terms[2]


def test_a_box_out_of_the_image_is_worth_nothing() -> None:
    away = orbit_pose(BOX.centre, 0.0, 0.6, 1.2)
    away[:3, :3] = away[:3, :3] @ np.diag([-1.0, 1.0, -1.0])  # looks the other way
    assert IncidenceTerm().gains(views(away)).tolist() == [0]
    assert BorderTerm().gains(views(away)).tolist() == [0]


def test_border_counts_the_outline_near_it() -> None:
    far, near = overhead(2.0), overhead(0.35)
    assert BorderTerm().gains(views(far, near))[0] == 1
    assert BorderTerm().gains(views(far, near))[1] < 0.5
    margins = [BorderTerm(k).gains(views(far))[0] for k in (0.0, 20.0, 30.0, 40.0, 60.0)]
    assert margins[0] == 1
    assert margins[-1] == 0  # every point of a 90 pixel high image is within 60 of its border
    assert np.all(np.diff(margins) <= 0)
    assert BorderTerm(20).name == "border_20px"


def test_terms_change_which_view_is_chosen() -> None:
    cameras = poses(rig("paper4"), Target(BOX.box_to_camera, BOX.extents))
    seen = BoxViews(BOX, cameras, CAMERA)
    histogram = ErrorHistogram.from_errors(np.array([[0.0, 0.3], [0.0, 0.0], [0.0, 0.0], [0.3, np.nan]]))
    known = ScannedBox(histogram, seen)
    alone, incidence = ProbabilityWithin().gains(histogram), IncidenceTerm().gains(seen)
    for weight in (0.0, 0.5, 2.0):
        both = WithTerms(ProbabilityWithin(), ((weight, IncidenceTerm()), (0.0, BorderTerm())))
        np.testing.assert_allclose(both.gains(known), alone + weight * incidence, rtol=1e-14)
        chosen = Choice(both, 0.8, 0.2).gains(known)
        assert np.argmax(chosen) == np.argmax(alone + weight * incidence)
    assert WithTerms(NearZero(), ((0.5, BorderTerm()), (0.0, IncidenceTerm()))).name == "near_zero + 0.5 border_1px"


def test_nonsense_is_refused() -> None:
    with pytest.raises(ConfigError, match="function"):
        IncidenceTerm("sine")  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="margin"):
        BorderTerm(-1.0)
    with pytest.raises(ConfigError, match="cameras"):
        ScannedBox(ErrorHistogram.from_errors(np.zeros((3, 2))), views(overhead(1.0)))

"""How much floor a camera sees: as counted pixel by pixel, less under larger boxes, none where a box fills the image."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewgain.box import Box, box_hits, entry_mask, floor_hits
from viewgain.camera import Sensor, sensor
from viewgain.geometry import inverse
from viewgain.plan._floor_in_view import FloorInView, floor_in_view
from viewgain.scenes import orbit_pose, standing_box

CAMERA = sensor("pico_flexx")


def seen(extents: tuple[float, float, float], *, elevation: float = 0.6, distance: float = 1.2, azimuth: float = 0.5) -> Box:
    box = standing_box(np.array(extents))
    return box.in_frame(inverse(orbit_pose(box.centre, azimuth, elevation, distance)))


def counted(box: Box, camera: Sensor) -> FloorInView:
    """Every pixel by itself."""
    floor, floor_area, area = 0.0, 0.0, 0.0
    for ray in camera.intrinsics.directions().reshape(-1, 1, 3):
        on_box = bool(entry_mask(box, ray)[0])
        hit = box_hits(box, ray) if on_box else floor_hits(box, ray)
        distance, cosine = float(hit.ranges[0]), float(hit.cosine[0])
        if not camera.range_min < distance < camera.range_max:
            continue
        comes_back = 1 - float(camera.loss(np.array([cosine]))[0])
        square = comes_back * distance**2 / max(cosine, 0.1)
        area += square
        if not on_box:
            floor, floor_area = floor + comes_back, floor_area + square
    return FloorInView(floor, floor_area / area)


@pytest.mark.parametrize(("extents", "elevation"), [((0.3, 0.2, 0.1), 0.6), ((0.9, 0.6, 0.5), 0.9), ((0.5, 0.4, 0.6), 0.25)])
def test_it_is_what_counting_every_pixel_gives(extents: tuple[float, float, float], elevation: float) -> None:
    box = seen(extents, elevation=elevation)
    few, all_of_them = floor_in_view(box, CAMERA), counted(box, CAMERA)
    pixels = CAMERA.intrinsics.width * CAMERA.intrinsics.height
    assert few.returns == pytest.approx(all_of_them.returns, abs=0.04 * pixels)
    assert few.share == pytest.approx(all_of_them.share, abs=0.04)
    assert 0.1 < few.share < 1


def test_a_box_that_fills_the_image_leaves_none() -> None:
    assert floor_in_view(seen((3.0, 3.0, 0.05), elevation=np.pi / 2), CAMERA) == FloorInView(0.0, 0.0)


def test_a_floor_out_of_range_or_above_the_horizon_is_none() -> None:
    assert floor_in_view(seen((0.3, 0.2, 0.1), distance=3 * CAMERA.range_max), CAMERA) == FloorInView(0.0, 0.0)
    upwards = seen((0.3, 0.2, 0.1)).in_frame(np.diag([1.0, -1.0, -1.0, 1.0]))  # the box lies behind
    assert floor_in_view(upwards, CAMERA) == FloorInView(0.0, 0.0)


@settings(deadline=None)
@given(
    side=st.floats(0.05, 1.0), height=st.floats(0.05, 0.4), more=st.floats(1.0, 2.0),
    elevation=st.floats(0.3, 1.4), azimuth=st.floats(-3, 3),
)  # fmt: skip
def test_a_larger_box_on_the_same_spot_hides_more(
    side: float, height: float, more: float, elevation: float, azimuth: float
) -> None:
    box = seen((side, side, height), elevation=elevation, azimuth=azimuth, distance=1.5)
    larger = Box(box.box_to_camera, box.extents * (more, more, 1.0))
    small, large = floor_in_view(box, CAMERA), floor_in_view(larger, CAMERA)
    assert large.returns <= small.returns
    assert 0 <= small.share <= 1
    assert 0 <= large.share <= 1


@settings(deadline=None)
@given(quarter=st.integers(1, 3), long=st.floats(0.1, 0.8))
def test_which_side_is_called_x_does_not_matter(quarter: int, long: float) -> None:
    box = seen((long, 0.3, 0.2))
    turn = np.eye(4)
    turn[:2, :2] = np.round([[np.cos(quarter * np.pi / 2), -np.sin(quarter * np.pi / 2)],
                             [np.sin(quarter * np.pi / 2), np.cos(quarter * np.pi / 2)]])  # fmt: skip
    same = Box(box.box_to_camera @ turn, box.extents[[1, 0, 2]] if quarter % 2 else box.extents)
    assert floor_in_view(same, CAMERA).returns == pytest.approx(floor_in_view(box, CAMERA).returns)
    assert floor_in_view(same, CAMERA).share == pytest.approx(floor_in_view(box, CAMERA).share)

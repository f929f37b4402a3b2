"""Incidence and border share: cases checked by hand, laws, and the flags that read them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from tests.box.cases import boxes
from viewgain.box import FACES, Box, border_share, clearance, constraints, edges_shown, incidence
from viewgain.camera import Intrinsics
from viewgain.geometry import inverse
from viewgain.scenes import orbit_pose, standing_box

CAMERA = Intrinsics.from_field_of_view(224, 171, *np.deg2rad([62.0, 45.0]))
SIZE = (CAMERA.width, CAMERA.height)


def to_pixels(image: np.ndarray) -> np.ndarray:
    return CAMERA.project(np.column_stack([image, np.ones(len(image))]))


def overhead(height: float) -> Box:
    """A cube of 0.2 m under a camera that looks straight down on its centre."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = height
    return Box(pose, np.array([0.2, 0.2, 0.2]))


def test_from_straight_above_only_the_top_is_seen_and_head_on() -> None:
    angles = incidence(overhead(1.0))
    assert angles[FACES.index("top")] == pytest.approx(0.0, abs=1e-7)
    assert np.all(np.isnan(np.delete(angles, FACES.index("top"))))


def test_a_front_seen_from_its_side_by_45_degrees() -> None:
    box = standing_box(np.array([0.4, 0.4, 0.4]))
    camera = orbit_pose(np.array([0.2, 0.0, 0.2]), np.deg2rad(45.0), 0.0, 1.0)  # looks at the centre of the face +x
    angles = incidence(box.in_frame(inverse(camera)))
    assert np.rad2deg(angles[FACES.index("+x")]) == pytest.approx(45.0)
    assert np.isnan(angles[FACES.index("-x")])


def test_a_box_in_the_middle_touches_no_border_and_a_near_one_all_of_it() -> None:
    assert border_share(overhead(1.0), to_pixels, SIZE) == 0.0
    assert border_share(overhead(0.25), to_pixels, SIZE) == 1.0
    assert border_share(overhead(0.1), to_pixels, SIZE) == 1.0  # reaches behind the camera


def test_the_border_share_is_the_share_of_points_strewn_along_the_outline() -> None:
    """The slow way: 20,000 points on the convex hull of the corners, each asked whether it is within a pixel of the border."""
    rng, box = np.random.default_rng(0), overhead(1.0)
    for right in (0.30, 0.45, 0.55):
        shift = np.eye(4)
        shift[0, 3] = right
        moved = box.in_frame(shift)
        corners = moved.corners()[:, :2] / moved.corners()[:, 2:]
        ends = ConvexHull(corners).simplices
        length = np.linalg.norm(corners[ends[:, 0]] - corners[ends[:, 1]], axis=1)
        side = ends[rng.choice(len(ends), 20_000, p=length / length.sum())]
        share = rng.uniform(size=(20_000, 1))
        u, v = to_pixels(corners[side[:, 0]] * share + corners[side[:, 1]] * (1 - share)).T
        on_border = (u < 0.5) | (v < 0.5) | (u > CAMERA.width - 1.5) | (v > CAMERA.height - 1.5)
        assert border_share(moved, to_pixels, SIZE) == pytest.approx(on_border.mean(), abs=0.02)


def test_an_edge_is_shown_as_far_as_it_lies_in_the_image() -> None:
    """A cube from above, its right half out of the image: its middle is where the border begins."""
    px, mx, py, my, top = range(5)
    whole = edges_shown(overhead(1.0), to_pixels, SIZE)
    assert np.all(whole[:4, top] == 1.0)
    assert whole[px, mx] == whole[py, my] == whole[top, top] == 0.0, "opposite faces share no edge"
    shift = np.eye(4)
    u = to_pixels(np.zeros((1, 2)))[0, 0]
    shift[0, 3] = (CAMERA.width - 1.5 - u) / CAMERA.fx * 0.8  # the top is 0.8 m away
    cut = edges_shown(overhead(1.0).in_frame(shift), to_pixels, SIZE)
    assert cut[px, top] == 0.0
    assert cut[mx, top] == 1.0
    assert cut[py, top] == pytest.approx(0.5, abs=1 / 32)


@settings(max_examples=40)
@given(boxes)
def test_edges_shown_are_shares_and_belong_to_both_faces(box: Box) -> None:
    shown = edges_shown(box, to_pixels, SIZE)
    assert np.all((shown >= 0) & (shown <= 1))
    np.testing.assert_array_equal(shown, shown.T)


@settings(max_examples=40)
@given(boxes, st.floats(-0.6, 0.6), st.floats(0.0, 3.0))
def test_edges_shown_are_those_of_a_walk_along_each(box: Box, aside: float, margin: float) -> None:
    """One edge after the other, the floor's four left out."""
    shift = np.eye(4)
    shift[0, 3] = aside
    moved = box.in_frame(shift)
    faces, corners = ((0, 0.5), (0, -0.5), (1, 0.5), (1, -0.5), (2, 1.0)), moved.corners()
    own = inverse(moved.box_to_camera)
    places = (np.column_stack([corners, np.ones(8)]) @ own.T)[:, :3] / moved.extents
    wanted = np.zeros((5, 5))
    for one, (axis, end) in enumerate(faces):
        for other, (across, side) in enumerate(faces):
            ends = corners[np.isclose(places[:, axis], end) & np.isclose(places[:, across], side)]
            if axis == across or np.any(ends[:, 2] <= 0.02):
                continue
            first, last = ends[:, :2] / ends[:, 2:]
            u, v = to_pixels(first + np.linspace(0, 1, 32)[:, None] * (last - first)).T
            inside = (u >= margin - 0.5) & (v >= margin - 0.5)
            inside &= (u <= CAMERA.width - 0.5 - margin) & (v <= CAMERA.height - 0.5 - margin)
            wanted[one, other] = inside.mean()
    np.testing.assert_allclose(edges_shown(moved, to_pixels, SIZE, margin), wanted, rtol=0, atol=1e-12)


def test_nothing_behind_the_camera_is_shown() -> None:
    assert not edges_shown(overhead(-1.0), to_pixels, SIZE).any()


@settings(max_examples=40)
@given(boxes, st.floats(0.0, 20.0))
def test_a_wider_margin_never_makes_the_border_share_smaller(box: Box, more: float) -> None:
    assert border_share(box, to_pixels, SIZE, 1.0 + more) >= border_share(box, to_pixels, SIZE, 1.0)


@settings(max_examples=40)
@given(boxes)
def test_shares_and_angles_are_within_their_bounds_and_opposite_faces_never_both_seen(box: Box) -> None:
    seen = constraints(box, to_pixels, SIZE)
    assert 0 <= seen.border <= 1
    assert seen.cut == (seen.border > 0)
    facing = np.isfinite(seen.incidence)
    assert np.all(seen.incidence[facing] < np.pi / 2)
    assert not (facing[0] and facing[1])
    assert not (facing[2] and facing[3])


@given(u=st.floats(-500, 500), v=st.floats(-500, 500))
def test_clearance_is_the_way_to_the_nearest_border_and_negative_beyond_it(u: float, v: float) -> None:
    """Pixel centres are whole numbers, so the border of the image lies half a pixel beyond the outermost ones."""
    width, height = SIZE
    found = float(clearance(np.array([[u, v]]), SIZE)[0])
    inside = -0.5 < u < width - 0.5 and -0.5 < v < height - 0.5
    assert (found > 0) == inside
    if inside:  # a step of that length towards the nearest border ends on it
        steps = [(-found, 0), (found, 0), (0, -found), (0, found)]
        ends = [clearance(np.array([[u + du, v + dv]]), SIZE)[0] for du, dv in steps]
        assert min(ends) == pytest.approx(0, abs=1e-9)
    mirrored = clearance(np.array([[width - 1 - u, v], [u, height - 1 - v]]), SIZE)
    assert mirrored == pytest.approx(found, abs=1e-9)

"""Wireframes: twelve edges, hidden ones by a slow search along the ray, face labels, and boxes that stand open."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from viewgain.box import Box
from viewgain.episodes import Episode
from viewgain.geometry import inverse
from viewgain.report._wire import (
    edges,
    faces,
    facing_camera,
    facing_direction,
    open_edges,
    open_side,
    reported_box,
    reported_extents,
    room,
)
from viewgain.scenes import orbit_pose, standing_box

BOX = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.3)


def seen_from(azimuth: float, elevation: float) -> Box:
    return BOX.in_frame(inverse(orbit_pose(BOX.centre, np.deg2rad(azimuth), np.deg2rad(elevation), 1.0)))


def blocked(box: Box, point: np.ndarray) -> bool:
    """Whether the box lies between the camera and a point, found by walking along the ray."""
    along = np.linspace(0, 0.999, 2000)[:, None] * point
    local = (along - box.box_to_camera[:3, 3]) @ box.box_to_camera[:3, :3]
    inside = np.all(np.abs(local[:, :2]) < box.extents[:2] / 2 - 1e-4, axis=1) & (local[:, 2] > 1e-4)
    return bool(np.any(inside & (local[:, 2] < box.extents[2] - 1e-4)))


@pytest.mark.parametrize(("azimuth", "elevation"), [(40, 30), (130, 60), (200, 10), (17.2, 20), (310, 85)])
def test_an_edge_is_hidden_where_the_box_stands_before_its_middle(azimuth: float, elevation: float) -> None:
    box = seen_from(azimuth, elevation)
    found = edges(box, facing_camera(box))
    assert len(found) == 12
    for edge in found:
        assert edge.hidden == blocked(box, edge.ends.mean(axis=0))


def test_edges_join_neighbouring_corners_and_no_others() -> None:
    ends = {tuple(sorted(tuple(np.round(corner, 9)) for corner in edge.ends)) for edge in edges(BOX, facing_camera(BOX))}
    assert len(ends) == 12
    local = [(corner - BOX.box_to_camera[:3, 3]) @ BOX.box_to_camera[:3, :3] for corner in BOX.corners()]
    near = sum(np.sum(np.abs(a - b) > 1e-9) == 1 for a, b in combinations(local, 2))
    assert near == 12


def test_from_far_away_the_viewer_sees_what_the_camera_sees() -> None:
    towards = np.array([np.cos(0.7), np.sin(0.7), 0.4])
    far = BOX.in_frame(inverse(orbit_pose(BOX.centre, 0.7, np.arctan(0.4), 1000.0)))
    np.testing.assert_array_equal(facing_direction(BOX, towards), facing_camera(far))


def test_faces_carry_their_names_centres_and_corners() -> None:
    found = faces(BOX, np.ones(6, dtype=bool))
    assert list(found) == ["+x", "−x", "+y", "−y", "top"]
    for face in found.values():
        np.testing.assert_allclose(face[0], face[1:].mean(axis=0), atol=1e-12)
        sides = np.linalg.norm(np.diff(face[[1, 2, 3, 4, 1]], axis=0), axis=1)
        np.testing.assert_allclose(sides[:2], sides[2:])
    np.testing.assert_allclose(found["top"][:, 2], 0.2)


def test_room_is_the_distance_from_the_centre_to_the_nearest_side() -> None:
    assert room(np.array([[0, 0], [-3, -1], [3, -1], [3, 1], [-3, 1]], dtype=float)) == pytest.approx(1.0)


def test_an_open_box_is_as_long_as_its_bound_and_keeps_the_face_that_was_seen(episode: Episode) -> None:
    narrow = episode.steps[0].fused.boxes[0]
    axis = int(np.flatnonzero(narrow.is_open)[0])
    estimate = replace(narrow, box=replace(narrow.box, extents=np.where(np.arange(3) == axis, 0.7, narrow.box.extents)))
    assert estimate.is_open == narrow.is_open
    box = reported_box(estimate)
    np.testing.assert_array_equal(box.extents, reported_extents(estimate))
    assert box.extents[axis] == estimate.intervals[axis].low
    seen = next(face.name for face in estimate.quality.faces if face.name[1:] == "xyz"[axis])
    label = seen.replace("-", "−")
    everything = np.ones(6, dtype=bool)
    assert open_side(estimate, axis) == (1 if seen[0] == "-" else -1)
    np.testing.assert_allclose(faces(box, everything)[label][0], faces(estimate.box, everything)[label][0], atol=1e-9)


def test_an_open_end_is_drawn_away_from_the_camera_and_a_closed_box_has_none(episode: Episode) -> None:
    lines = open_edges(episode.steps[0].fused.boxes[0])
    assert len(lines) == 4
    assert all(line[1, 2] > line[0, 2] + 0.5 for line in lines)
    closed = episode.steps[1].fused.boxes[0]
    assert open_edges(closed) == []
    np.testing.assert_allclose(reported_box(closed).corners(), closed.box.corners())

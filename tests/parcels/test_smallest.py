"""Smallest boxes against brute force over all orientations, and the laws they obey."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from viewgain.geometry import pose, transform
from viewgain.parcels import smallest_box, smallest_rectangle, upright_box


def brute_force(points: np.ndarray) -> float:
    """The least volume over 4,000 random orientations, the best ones shaken until nothing gets smaller."""
    rng = np.random.default_rng(0)
    turns = Rotation.random(4000, random_state=rng).as_matrix()
    volumes = np.prod(np.ptp(points @ turns, axis=1), axis=1)
    best = np.inf
    for start in np.argsort(volumes)[:6]:
        frame, least, step = turns[start], volumes[start], 0.1
        while step > 1e-3:
            tried = frame @ Rotation.from_rotvec(rng.normal(0, step, (40, 3))).as_matrix()
            values = np.prod(np.ptp(points @ tried, axis=1), axis=1)
            k = int(np.argmin(values))
            frame, least, step = (tried[k], values[k], step) if values[k] < least else (frame, least, step * 0.7)
        best = min(best, least)
    return float(best)


@pytest.mark.parametrize("seed", range(8))
def test_no_orientation_gives_a_box_smaller_by_half_a_per_cent(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(5, 40)), 3)) * rng.uniform(0.1, 0.5, 3)
    found = smallest_box(points)
    assert found.volume < 1.005 * brute_force(points)


@given(st.integers(0, 10_000))
def test_a_turned_box_is_found_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    extents = np.sort(rng.uniform(0.05, 0.6, 3))[::-1]
    corners = (np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T) * extents
    motion = pose(Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3))
    found = smallest_box(transform(motion, corners))
    np.testing.assert_allclose(found.extents, extents, rtol=2e-3)
    np.testing.assert_allclose(found.centred_to_frame[:3, 3], motion[:3, 3], atol=1e-3)


@given(st.integers(0, 10_000))
def test_both_boxes_hold_all_points_and_the_free_one_is_never_larger(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * rng.uniform(0.1, 0.5, 3)
    points[:, 2] -= points[:, 2].min()
    standing, free = upright_box(points), smallest_box(points)
    for box in (standing, free):
        inside = (points - box.centred_to_frame[:3, 3]) @ box.centred_to_frame[:3, :3]
        assert np.all(np.abs(inside) <= box.extents / 2 + 1e-9)
        np.testing.assert_allclose(box.centred_to_frame[:3, :3] @ box.centred_to_frame[:3, :3].T, np.eye(3), atol=1e-9)
        assert np.linalg.det(box.centred_to_frame[:3, :3]) > 0
    assert free.volume <= standing.volume * (1 + 1e-3)
    assert standing.extents[0] >= standing.extents[1]


def test_the_smallest_rectangle_beats_every_yaw() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        points = rng.normal(size=(25, 2)) * rng.uniform(0.1, 1, 2)
        _, low, high = smallest_rectangle(points)
        yaws = np.linspace(0, np.pi / 2, 2000)
        x = np.outer(np.cos(yaws), points[:, 0]) + np.outer(np.sin(yaws), points[:, 1])
        y = np.outer(np.cos(yaws), points[:, 1]) - np.outer(np.sin(yaws), points[:, 0])
        assert np.prod(high - low) <= (np.ptp(x, axis=1) * np.ptp(y, axis=1)).min() * (1 + 1e-12)


def test_flat_and_straight_things_have_boxes_without_volume() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0.0]])
    np.testing.assert_allclose(smallest_box(square).extents, [2, 1, 0], atol=1e-6)
    line = np.linspace([0, 0, 0], [1, 1, 1], 10)
    np.testing.assert_allclose(smallest_box(line).extents, [np.sqrt(3), 0, 0], atol=1e-6)
    np.testing.assert_allclose(upright_box(square).extents, [2, 1, 0], atol=1e-12)

"""Directions that a person can follow."""

import numpy as np
import pytest

from viewgain.geometry import inverse, look_at, pose, rotation_from_rotvec, transform
from viewgain.plan import directions_in_words
from viewgain.scenes import orbit_pose

TARGET = np.array([0.0, 0.0, 0.2])
PRESENT = (30.0, 40.0, 1.0)


def words(azimuth: float, elevation: float, distance: float, *, present: tuple[float, float, float] = PRESENT) -> str:
    """How to get from the present azimuth, elevation (degrees) and distance to another."""
    here, there = (orbit_pose(TARGET, *np.deg2rad(angles[:2]), angles[2]) for angles in (present, (azimuth, elevation, distance)))
    to_current = inverse(here)
    return directions_in_words(to_current @ there, transform(to_current, TARGET), to_current[:3, 2])


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((75, 40, 1.0), "move 45 degrees to the right, same distance"),
        ((-15, 40, 1.0), "move 45 degrees to the left, same distance"),
        ((210, 40, 1.0), "move to the opposite side, same distance"),
        ((30, 60, 1.0), "move 0.22 m up, same distance"),
        ((30, 20, 1.0), "move 0.30 m down, same distance"),
        ((120, 60, 1.0), "move 90 degrees to the right, 0.22 m up, same distance"),
        ((30, 40, 1.0), "stay there"),
        ((165, 20, 1.3), "move 135 degrees to the right, 0.20 m down, 0.30 m further away"),
        ((30, 90, 1.0), "move 0.36 m up, same distance"),
    ],
)
def test_places_in_words(place: tuple[float, float, float], expected: str) -> None:
    assert words(*place) == expected


def test_nearer_and_farther() -> None:
    assert words(30, 40, 0.75).endswith("0.25 m closer")
    assert words(30, 40, 1.25).endswith("0.25 m further away")
    assert "0.16 m down" in words(30, 40, 0.75)


def test_a_hair_of_difference_is_not_worth_a_word() -> None:
    assert words(30.2, 40.1, 1.004) == "stay there"


def test_a_camera_aimed_elsewhere_is_told_to_aim_at_the_box() -> None:
    here = orbit_pose(TARGET, *np.deg2rad(PRESENT[:2]), 1.0) @ pose(rotation_from_rotvec(np.array([0.0, 0.2, 0.0])), np.zeros(3))
    aimed = look_at(here[:3, 3], TARGET, np.array([0.0, 0.0, 1.0]))
    to_current = inverse(here)
    said = directions_in_words(to_current @ aimed, transform(to_current, TARGET), to_current[:3, 2])
    assert said == "stay there and aim at the box"


def test_from_straight_overhead_there_is_no_left_and_no_right() -> None:
    said = words(120, 40, 1.0, present=(0.0, 90.0, 1.0))
    assert "degrees" not in said
    assert "0.36 m down" in said

"""A candidate pose in words that a person at the camera can follow."""

import numpy as np

from viewgain.arrays import Pose, Vector3


def directions_in_words(camera_to_current: Pose, target: Vector3, up: Vector3) -> str:
    """Return how to get to a candidate, such as "move 45 degrees to the right, 0.20 m up, same distance".

    Args:
        camera_to_current: (4, 4) the candidate's pose.
        target: (3,) what both cameras look at, metres, present camera's frame.
        up: (3,) the floor's normal, present camera's frame.
    """
    before, after = -target, camera_to_current[:3, 3] - target
    turn = turn_about(before, after, up)
    rise = float((after - before) @ up)
    further = float(np.linalg.norm(after) - np.linalg.norm(before))
    parts = []
    if abs(turn) >= 0.5:
        parts.append(
            "to the opposite side" if abs(turn) > 179.5 else f"{abs(turn):.0f} degrees to the {'right' if turn > 0 else 'left'}"
        )
    if abs(rise) >= 0.01:
        parts.append(f"{abs(rise):.2f} m {'up' if rise > 0 else 'down'}")
    distance = "same distance" if abs(further) < 0.01 else f"{abs(further):.2f} m {'further away' if further > 0 else 'closer'}"
    if not parts and abs(further) < 0.01:
        return "stay there and aim at the box" if np.hypot(*camera_to_current[:2, 2]) > 0.02 else "stay there"
    return f"move {', '.join([*parts, distance])}"


def turn_about(before: Vector3, after: Vector3, up: Vector3) -> float:
    """Return the turn about ``up`` in degrees, positive to the camera's right; 0 if either is straight overhead."""
    level_before, level_after = before - (before @ up) * up, after - (after @ up) * up
    if min(np.linalg.norm(level_before), np.linalg.norm(level_after)) < 1e-6:
        return 0.0
    return float(np.rad2deg(np.arctan2(np.cross(level_before, level_after) @ up, level_before @ level_after)))

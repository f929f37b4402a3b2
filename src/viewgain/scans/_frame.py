"""Which way the camera looks: clouds along -z are turned to the package's camera frame (x right, y down, z forward)."""

import numpy as np

from viewgain.arrays import Array, Points, Pose

BEHIND = 0.95
"""Share of points with z < 0 above which the file's camera looks along -z (Blender, OpenGL)."""
OFF_AXIS = np.radians(40)
"""Depth cameras see at most this far between their line of sight and the middle of the scene (real scans: under 18 degrees)."""

_TURN = np.array([1.0, -1.0, -1.0])


def face_forward(
    points: Array, normals: Array | None, pose: Pose | None
) -> tuple[Array, Array | None, Pose | None, tuple[str, ...]]:
    """Return a cloud in the camera frame, turned by (x, -y, -z) where its camera looks along -z.

    Args:
        points: (..., 3) points; returns that are not finite or at the origin do not vote.
        normals: Normals of the same shape, turned alike.
        pose: Pose that takes the file's coordinates to the world; the returned one takes the turned ones there.

    Returns:
        Points, normals, pose, and what was decided, as notes.
    """
    flat = points.reshape(-1, 3)
    valid = flat[np.isfinite(flat).all(axis=1) & (np.abs(flat).max(axis=1, initial=0) > 0)]
    if len(valid) == 0:
        return points, normals, pose, ()
    behind = float(np.mean(valid[:, 2] < 0))
    notes: list[str] = []
    if behind > BEHIND:
        points, valid = points * _TURN, valid * _TURN
        normals = None if normals is None else normals * _TURN
        pose = None if pose is None else pose @ np.diag([*_TURN, 1.0])
        notes.append(f"axes: {behind:.0%} of the points have z < 0 (camera looks along -z); turned by (x, -y, -z)")
    reason = _not_a_camera(valid, behind)
    if reason:
        notes.append(f"axes: the cloud does not look like a single camera-frame scan: {reason}")
    return points, normals, pose, tuple(notes)


def _not_a_camera(valid: Points, behind: float) -> str | None:
    if 1 - BEHIND < behind <= BEHIND:
        return f"{behind:.0%} of the points lie behind the camera (z < 0)"
    middle = np.median(valid / np.linalg.norm(valid, axis=1, keepdims=True), axis=0)
    angle = float(np.arctan2(np.linalg.norm(middle[:2]), middle[2]))
    if angle > OFF_AXIS:
        return f"its middle is {np.degrees(angle):.0f} degrees off the camera's line of sight (z)"
    return None


def unit_normals(normals: Array | None) -> Array | None:
    """Return (..., 3) normals scaled to length 1; NaN or zero ones (the file had none there) are NaN."""
    if normals is None:
        return None
    lengths = np.linalg.norm(normals, axis=-1, keepdims=True)
    return np.where(lengths > 0, normals / np.where(lengths > 0, lengths, 1.0), np.nan)

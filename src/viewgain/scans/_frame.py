"""Which way the camera looks: clouds in other axes are turned to the package's camera frame (x right, y down, z forward)."""

import numpy as np

from viewgain.arrays import Array, Points, Pose

BEHIND = 0.95
"""Share of points with z < 0 above which the file's camera looks along -z (Blender, OpenGL)."""
OFF_AXIS = np.radians(40)
"""Depth cameras see at most this far between their line of sight and the middle of the scene (real scans: under 18 degrees)."""
AGREEMENT = 0.9
"""Share of neighbouring pixels that must agree on where an axis points in the image."""

_BACKWARDS = np.array([1.0, -1.0, -1.0])
_UPSIDE_DOWN = np.array([-1.0, -1.0, 1.0])

Turned = tuple[Array, Array | None, Pose | None]


def face_forward(points: Array, normals: Array | None, pose: Pose | None) -> tuple[Turned, tuple[str, ...]]:
    """Return a cloud in the camera frame, turned where its axes are another camera convention.

    A camera that looks along -z is turned by (x, -y, -z); an image whose columns run along -x and rows along -y by (-x, -y, z).

    Args:
        points: (n, 3) or (h, w, 3) points; returns that are not finite or at the origin do not vote.
        normals: Normals of the same shape, turned alike.
        pose: Pose that takes the file's coordinates to the world; the returned one takes the turned ones there.

    Returns:
        (points, normals, pose), and what was decided, as notes.
    """
    valid = _valid(points)
    if len(valid) == 0:
        return (points, normals, pose), ()
    notes: list[str] = []
    behind = float(np.mean(valid[:, 2] < 0))
    if behind > BEHIND:
        points, normals, pose = _turned(_BACKWARDS, points, normals, pose)
        notes.append(f"axes: {behind:.0%} of the points have z < 0 (camera looks along -z); turned by (x, -y, -z)")
    signs = _image_signs(points) if points.ndim == 3 else (0, 0)
    if signs == (-1, -1):
        points, normals, pose = _turned(_UPSIDE_DOWN, points, normals, pose)
        notes.append("axes: x points left and y up in the image; turned by (-x, -y, z)")
    elif -1 in signs and 1 in signs:
        notes.append(
            "axes: the cloud is mirrored (x or y, not both, runs against the image); sizes are right, left and right are not"
        )
    reason = _not_a_camera(_valid(points), behind)
    if reason:
        notes.append(f"axes: the cloud does not look like a single camera-frame scan: {reason}")
    return (points, normals, pose), tuple(notes)


def _valid(points: Array) -> Points:
    flat = points.reshape(-1, 3)
    return np.asarray(flat[np.isfinite(flat).all(axis=1) & (np.abs(flat).max(axis=1, initial=0) > 0)])


def _turned(signs: Array, points: Array, normals: Array | None, pose: Pose | None) -> Turned:
    pose = None if pose is None else pose @ np.diag([*signs, 1.0])
    return points * signs, None if normals is None else normals * signs, pose


def _image_signs(points: Array) -> tuple[int, int]:
    """Return the direction of x along the columns and of y along the rows of the image: 1, -1, or 0 where pixels disagree."""
    lengths = np.linalg.norm(points, axis=-1, keepdims=True)
    directions = points / np.where(lengths > 0, lengths, np.nan)
    steps = (np.diff(directions[..., 0], axis=1), np.diff(directions[..., 1], axis=0))
    signs = []
    for step in steps:
        known = step[np.isfinite(step)]
        backwards = np.mean(known < 0) if known.size else 0.5
        signs.append(-1 if backwards > AGREEMENT else int(backwards < 1 - AGREEMENT))
    return signs[0], signs[1]


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

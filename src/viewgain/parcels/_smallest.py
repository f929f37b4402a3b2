"""The smallest box around points: standing on a floor, and in any orientation.

A smallest rectangle has a side along a side of the hull (Freeman and Shapira 1975). A smallest box need not lie on a face of the
hull, but two of its adjacent faces each hold an edge of it (O'Rourke 1985); we take the best boxes that do lie on a face and turn
them freely until nothing gets smaller (ours; tests compare it with brute force over all orientations).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, QhullError

from viewgain.arrays import Array, Points, Points2, Pose, Rotation, Vector3
from viewgain.geometry import pose, rotation_from_rotvec

_MAX_FACES = 150
"""Of a hull with more faces than this, the largest ones are tried: the small ones between them are nearly parallel to one."""
_STARTS = 8
_TURN = 0.08
"""First step of the free turning, radians."""


@dataclass(frozen=True, slots=True, eq=False)
class Cuboid:
    """A box anywhere."""

    centred_to_frame: Pose
    """(4, 4) pose: origin at the box's centre, axes along its sides."""
    extents: Vector3
    """(3,) side lengths along those axes, metres."""

    @property
    def volume(self) -> float:
        """Volume, cubic metres."""
        return float(np.prod(self.extents))


def upright_box(points: Points) -> Cuboid:
    """Return the smallest box with one side vertical that holds (n, 3) ``points`` (n >= 1) and stands on the floor z = 0.

    The rectangle of least area around the footprint, times the height of the highest point. x is the longer horizontal side.
    """
    yaw, low, high = smallest_rectangle(points[:, :2])
    sides, height = high - low, max(float(points[:, 2].max()), 0.0)
    turn, middle = yaw, (low + high) / 2
    if sides[0] < sides[1]:
        turn, middle, sides = yaw + np.pi / 2, np.array([middle[1], -middle[0]]), sides[::-1]
    rotation = rotation_from_rotvec(np.array([0.0, 0.0, turn]))
    centre = rotation @ np.array([*middle, height / 2])
    return Cuboid(pose(rotation, centre), np.array([*sides, height]))


def smallest_box(points: Points) -> Cuboid:
    """Return the box of least volume, in any orientation, that holds (n, 3) ``points`` (n >= 1).

    Sides are in descending order. Points in one plane give a box of no thickness, points on a line one of length only.
    """
    hull = _hull(points)
    if hull is None:
        return _around(points, _flat_frame(points))
    corners = points[hull.vertices]
    frames = [_frame_on(normal, corners) for normal in _face_normals(hull)]
    volumes = np.array([np.prod(np.ptp(corners @ frame, axis=0)) for frame in frames])
    starts = [frames[k] for k in np.argsort(volumes)[:_STARTS]]
    turned = [_turned(corners, frame) for frame in starts]
    return _around(corners, min((*starts, *turned), key=lambda frame: float(np.prod(np.ptp(corners @ frame, axis=0)))))


def smallest_rectangle(points: Points2) -> tuple[float, Array, Array]:
    """Return the rectangle of least area around (n, 2) points: yaw of a side, radians, and lowest and highest corner, (2,) each.

    The corners are in the frame turned by the yaw. A single point gives zero sides, a line of points a zero width.
    """
    outline = _outline(points)
    steps = np.roll(outline, -1, axis=0) - outline
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    cosine, sine = np.cos(yaws)[:, None], np.sin(yaws)[:, None]
    x = cosine * outline[:, 0] + sine * outline[:, 1]
    y = cosine * outline[:, 1] - sine * outline[:, 0]
    best = int(np.argmin(np.ptp(x, axis=1) * np.ptp(y, axis=1)))
    return float(yaws[best]), np.array([x[best].min(), y[best].min()]), np.array([x[best].max(), y[best].max()])


def _outline(points: Points2) -> Points2:
    """Return the corners of the convex hull in order; both ends where all points lie on a line."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        centred = points - points.mean(axis=0)
        along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
        return np.asarray(points[[int(np.argmin(along)), int(np.argmax(along))]])


def _hull(points: Points) -> ConvexHull | None:
    """Return the convex hull, or None where the points have no volume."""
    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


def _face_normals(hull: ConvexHull) -> Points:
    """Return the normals of the hull's faces, parallel ones once, the faces of greatest area first."""
    corners = hull.points[hull.simplices]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    normals = hull.equations[np.argsort(-area, kind="stable"), :3]
    rounded = np.round(normals, 4)
    _, first = np.unique(rounded * np.where(rounded[:, 2:] < 0, -1.0, 1.0), axis=0, return_index=True)
    return np.asarray(normals[np.sort(first)[:_MAX_FACES]])


def _frame_on(normal: Vector3, corners: Points) -> Rotation:
    """Return the frame (columns are axes) with its third axis along ``normal`` in which the corners' box is smallest."""
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    plane = np.stack([first, np.cross(normal, first)], axis=1)
    yaw = smallest_rectangle(corners @ plane)[0]
    x = plane @ np.array([np.cos(yaw), np.sin(yaw)])
    return np.stack([x, np.cross(normal, x), normal], axis=1)


def _turned(corners: Points, frame: Rotation) -> Rotation:
    """Return the frame after free turning to a local minimum of the volume (Nelder and Mead 1965)."""

    def volume(turn: Array) -> float:
        return float(np.prod(np.ptp(corners @ frame @ rotation_from_rotvec(turn), axis=0)))

    simplex = np.vstack([np.zeros(3), _TURN * np.eye(3)])
    options = {"initial_simplex": simplex, "xatol": 1e-4, "fatol": 1e-12, "maxfev": 250}
    found = minimize(volume, np.zeros(3), method="Nelder-Mead", options=options)
    return np.asarray(frame @ rotation_from_rotvec(np.asarray(found.x)))


def _flat_frame(points: Points) -> Rotation:
    """Return the frame of the smallest rectangle of points that lie in a plane, as far as they do."""
    axes = np.linalg.svd(points - points.mean(axis=0))[2]
    normal = np.cross(axes[0], axes[1])
    return _frame_on(normal, points)


def _around(points: Points, frame: Rotation) -> Cuboid:
    """Return the box of ``points`` in a frame, its longest side first, right-handed."""
    turned = points @ frame
    low, high = turned.min(axis=0), turned.max(axis=0)
    centre = frame @ ((low + high) / 2)
    order = np.argsort(-(high - low), kind="stable")
    axes = frame[:, order]
    if np.linalg.det(axes) < 0:
        axes = axes * (1.0, 1.0, -1.0)
    return Cuboid(pose(axes, centre), (high - low)[order])

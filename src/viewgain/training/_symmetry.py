"""Turns about the vertical and mirrors that carry a rig onto itself: what a cloud may undergo while its labels stay exact.

A turn or a mirror image of an object is an object too, and what view k saw of the one, the view that k is carried to sees of the
other. So the scores are the same numbers on other views. A motion that carries a view to where none stands leaves a place vacant,
whose score is not known. The 33 views of PC-NBV have 16 symmetries; their first 16 views have 2, and 14 more that leave one place
vacant. Ours.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Points, Poses
from viewgain.datasets import Frame
from viewgain.errors import DataError

_NEAR = 1e-3
"""Two cameras stand at the same place if they are this near, in distances from the centre."""
LOST = -1
"""Where a view is carried to if no view stands there."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Symmetries:
    """G motions of a rig of V views; the first is to leave all as it is."""

    carried: NDArray[np.int64]
    """(G, V) the view that each view is carried to, or :data:`LOST`."""
    maps: Array
    """(G, V, 3, 3) what to do with the points of a sample taken from each view, in the frame of its points; of a view that gets
    lost it means nothing."""

    def __len__(self) -> int:
        return len(self.carried)


def symmetries(poses: Poses, frame: Frame, *, vacant: int = 0) -> Symmetries:
    """Return the symmetries of a rig.

    Args:
        poses: (V, 4, 4) camera to object; the object's z axis is the vertical, its origin the centre.
        frame: In which the points of the samples are.
        vacant: Places that a motion may leave vacant, 0 for symmetries in the strict sense.

    Raises:
        DataError: If the poses are not known, or nothing but the identity carries the rig onto itself.
    """
    if not np.all(np.isfinite(poses)):
        raise DataError("symmetry: got data without poses of its views; wanted them known; switch symmetry off in the recipe")
    places = poses[:, :3, 3]
    found = [(np.eye(3), np.arange(len(places)))]
    for motion in _candidates(places):
        carried = _carried(places, motion, vacant)
        if carried is not None and not any(np.array_equal(carried, other) for _, other in found):
            found.append((motion, carried))
    if len(found) == 1:
        raise DataError("symmetry: got a rig that no turn or mirror carries onto itself; switch symmetry off in the recipe")
    motions = np.stack([motion for motion, _ in found])
    carried = np.stack([views for _, views in found])
    return Symmetries(carried=carried, maps=_maps(poses, motions, carried, frame))


def _maps(poses: Poses, motions: Array, carried: NDArray[np.int64], frame: Frame) -> Array:
    """Return (G, V, 3, 3): in the object's frame the motion itself; in the camera's, seen from the view that it leads to."""
    if frame == "object":
        return np.repeat(motions[:, None], len(poses), axis=1)
    turns = poses[:, :3, :3]
    return np.swapaxes(turns[carried], -1, -2) @ motions[:, None] @ turns


def _candidates(places: Points) -> Iterator[Array]:
    """Yield every turn and mirror that carries a camera to one as far from the axis and as high, the farthest cameras first."""
    away = np.hypot(places[:, 0], places[:, 1])
    near = _NEAR * float(np.linalg.norm(places, axis=1).max())
    angles = np.arctan2(places[:, 1], places[:, 0])
    for first in np.argsort(-away, kind="stable"):
        alike = (np.abs(away - away[first]) < near) & (np.abs(places[:, 2] - places[first, 2]) < near)
        for angle in angles[alike]:
            yield _turn(angle - angles[first])
            yield _mirror((angle + angles[first]) / 2)


def _carried(places: Points, motion: Array, vacant: int) -> NDArray[np.int64] | None:
    """Return (V,) where each camera lands; None if more than ``vacant`` land where no camera stands."""
    gaps = np.linalg.norm((places @ motion.T)[:, None] - places[None], axis=2)
    lost = gaps.min(axis=1) > _NEAR * np.linalg.norm(places, axis=1).max()
    if lost.sum() > vacant:
        return None
    return np.where(lost, LOST, gaps.argmin(axis=1)).astype(np.int64)


def _turn(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _mirror(angle: float) -> Array:
    """Return the mirror in the vertical plane of this azimuth."""
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    return np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]])

"""What stands on the floor, from several posed scans together: the points that no scan looks through (ours)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Mask, Points, Pose
from viewgain.camera import Sensor
from viewgain.errors import ScanError
from viewgain.geometry import inverse, pose, rotation_from_rotvec, transform
from viewgain.measure import RangeImage, find_floors, range_image, sensor_of
from viewgain.parcels._objects import find_objects
from viewgain.scans import Scan

FOOT = 0.02
"""What comes down to within this of the lowest point seen stands on the floor, metres."""
_CLEARANCE, _SIGMAS = 0.01, 4.0
"""A scan looks through a point if its return lies farther by so many metres and spreads of its noise, as among neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """What one scan shows of all that stands on the floor."""

    points: Points
    """(n, 3) smoothed returns, metres, in a world whose floor is z = 0."""
    camera_to_world: Pose
    """(4, 4) where the camera is in that world."""
    image: RangeImage
    """The whole scan."""
    sigma: float
    """Noise of one return on it, metres."""


def standing(scan: Scan, *, camera: str | Sensor | None = None) -> Standing | None:
    """Return all that stands on the floor of a scan; None where there is no floor or nothing on it.

    Heights count from the floor that the scan shows, and only place and heading are taken from the scan's pose: what the camera
    believes of its height and tilt is worse than what it sees. So what several scans show can be put together.

    Args:
        scan: A scan with ``camera_to_world``.
        camera: Preset name or sensor, as :func:`viewgain.parcels.enclose` wants it.

    Raises:
        ScanError: If the scan has no pose.
        ConfigError: If ``camera`` names no preset.
    """
    if scan.camera_to_world is None:
        raise ScanError(f"{scan.source}: what several scans show can be put together by poses alone; give camera_to_world")
    known = sensor_of(camera)
    image = range_image(scan).corrected(known)
    model = replace(known, intrinsics=image.whole_camera())
    floors = find_floors(image, model)
    objects = find_objects(image, floors[0], model) if floors else []
    if not objects:
        return None
    frame = objects[0].floor_frame
    level = levelled(scan.camera_to_world, frame)
    points = transform(level, np.concatenate([seen.points for seen in objects]))
    return Standing(points, level @ inverse(frame), image, max(seen.sigma for seen in objects))


def standing_points(parts: Sequence[Standing]) -> Points:
    """Return (n, 3) points of what stands on the floor z = 0, from all scans of it together, metres; (0, 3) without any.

    A point that another scan looks through is left out: a mixed pixel, or noise that stands off the surface. Points within
    :data:`FOOT` of the lowest are there a second time on the floor itself, where the returns of the two cannot be told apart.
    """
    kept = [
        part.points[~np.any([looks_through(other, part.points) for other in parts if other is not part], axis=0)]
        if len(parts) > 1
        else part.points
        for part in parts
    ]
    points = np.concatenate([np.zeros((0, 3)), *kept])
    if not len(points):
        return points
    feet = points[points[:, 2] < points[:, 2].min() + FOOT] * (1.0, 1.0, 0.0)
    return np.concatenate([points, feet])


def looks_through(other: Standing, points: Points) -> Mask:
    """Return (n,) which of (n, 3) points a scan looks through: the pixel that they fall on has its return well behind them."""
    local = transform(inverse(other.camera_to_world), points)
    height, width = other.image.ranges.shape
    through = np.zeros(len(points), dtype=bool)
    ahead = np.flatnonzero(local[:, 2] > 0)
    pixels = np.round(other.image.plane.to_pixels(local[ahead, :2] / local[ahead, 2:])).astype(int)
    inside = np.all((pixels >= 0) & (pixels < (width, height)), axis=1)
    chosen, (columns, rows) = ahead[inside], pixels[inside].T
    behind = other.image.ranges[rows, columns] - np.linalg.norm(local[chosen], axis=1)
    through[chosen] = behind > _CLEARANCE + _SIGMAS * other.sigma  # a pixel without a return says nothing: NaN is no more
    return through


def levelled(camera_to_world: Pose, floor_to_camera: Pose) -> Pose:
    """Return floor_to_world, (4, 4): the heading and place of the camera kept, z upright, and the foot under it on z = 0."""
    along = camera_to_world[:3, :3] @ floor_to_camera[:3, 0]
    heading = rotation_from_rotvec(np.array([0.0, 0.0, np.arctan2(along[1], along[0])]))
    return pose(heading, np.array([*camera_to_world[:2, 3], 0.0]))

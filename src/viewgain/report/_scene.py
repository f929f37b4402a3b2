"""What the picture in space is about, as plain data: frames, places and which returns belong to the object."""

from collections.abc import Sequence

import numpy as np

from viewgain.arrays import Mask, Points, Pose, Vector3
from viewgain.geometry import floor_to_camera, transform
from viewgain.measure import Measurement
from viewgain.plan import NextView
from viewgain.report._viewpoint import Viewpoint, clearest
from viewgain.report._wire import reported_box

LEVEL = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""Pose of a level camera that looks along the world's y axis."""
ASIDE = np.deg2rad(35.0)
"""The viewer stands this far to the side of the present camera."""


def viewpoint(measurement: Measurement, plan: NextView | None) -> Viewpoint:
    """Return the clearest viewpoint for a measurement and the cameras of its plan."""
    centre, cameras = object_centre(measurement), camera_places(measurement, plan, ())
    ahead = world_of(measurement)[:3, 3] - centre
    return clearest(centre, cameras, float(np.arctan2(ahead[1], ahead[0])) + ASIDE)


def world_of(measurement: Measurement) -> Pose:
    """Return (4, 4) camera_to_world; that of a level camera at the origin where neither a pose nor a floor says more."""
    if measurement.camera_to_world is None and measurement.floor is None:
        return LEVEL
    return measurement.world


def object_centre(measurement: Measurement) -> Vector3:
    """Return (3,) the middle of what the pictures are about: first box, else largest object, else the point 1 m ahead."""
    world = world_of(measurement)
    if measurement.boxes:
        return transform(world, measurement.boxes[0].box.centre)
    if measurement.rejected:
        return transform(world, measurement.rejected[0].centre)
    return transform(world, np.array([0.0, 0.0, 1.0]))


def camera_places(measurement: Measurement, plan: NextView | None, earlier: Sequence[Pose]) -> Points:
    """Return (k, 3) where cameras stand, world frame: the present one, the candidates and the earlier ones."""
    world = world_of(measurement)
    candidates = [] if plan is None else [world @ candidate.camera_to_current for candidate in plan.candidates]
    return np.array([pose[:3, 3] for pose in (world, *candidates, *earlier)])


def floor_height(measurement: Measurement) -> float:
    """Return the height of the measured floor in the world, under the camera, metres."""
    assert measurement.floor is not None
    return float((measurement.world @ floor_to_camera(measurement.floor.plane))[2, 3])


def on_object(points: Points, measurement: Measurement) -> Mask:
    """Return the (n,) mask of camera-frame points within 1.5 cm of a measured box, or else in the bounds of a rejected object."""
    mask = np.zeros(len(points), dtype=bool)
    for box in (reported_box(estimate) for estimate in measurement.boxes):
        local = (points - box.box_to_camera[:3, 3]) @ box.box_to_camera[:3, :3]
        sides = np.all(np.abs(local[:, :2]) < box.extents[:2] / 2 + 0.015, axis=1)
        mask |= sides & (local[:, 2] > 0.005) & (local[:, 2] < box.extents[2] + 0.015)
    if measurement.floor is None or measurement.boxes:
        return mask
    for blob in measurement.rejected:
        mask |= np.all(np.abs(points - blob.centre) < 1.05 * blob.spread, axis=1) & (
            measurement.floor.plane.height(points) > 0.015
        )
    return mask

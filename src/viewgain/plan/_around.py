"""What the candidates stand around, and which of them can be reached."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Pose, Poses
from viewgain.geometry import inverse
from viewgain.plan._belief import Belief, floor_pose
from viewgain.plan._predict import predict
from viewgain.rigs import Rig, Station, Target, place, refusals

STEPS_BACK = (1.0, 1.15, 1.3, 1.5, 1.75, 2.0)
"""Factors on the present distance that are tried until the box fits into the image."""


def step_back(belief: Belief) -> float:
    """Return the least factor on the present distance at which the believed box fits into the image; the largest if none does.

    A camera too near cuts the box from every side of a ring; going around at the same distance would not help.
    """
    here = Rig(name="here", stations=(Station(),))
    for factor in STEPS_BACK:
        (pose,) = place(here, target_of(belief), floor_pose(belief), None, step_back=factor)
        if not predict(belief.mean, pose, belief.sensor, belief.noise).cut:
            return factor
    return STEPS_BACK[-1]


def target_of(belief: Belief) -> Target:
    """Return what the candidates stand around: the middle box, in the floor's frame."""
    return Target(inverse(floor_pose(belief)) @ belief.mean.box_to_camera, belief.mean.extents)


def reachable_of(poses: Poses, belief: Belief, stations: Rig, camera_to_world: Pose | None) -> tuple[bool, ...]:
    """Return which candidates the rig and the camera's least range allow, next to what has been seen: the smallest box.

    Of boxes that are only guessed at none is sure to be there and none sure not to be: a candidate keeps away from all of them.
    """
    limits = replace(stations, min_distance=max(stations.min_distance, belief.sensor.range_min))
    allowed = np.ones(len(poses), dtype=bool)
    for box in belief.boxes if belief.glimpsed else belief.boxes[:1]:  # its own frame has its floor at z = 0
        world = None if camera_to_world is None else camera_to_world @ box.box_to_camera
        cameras = inverse(box.box_to_camera) @ poses
        reasons = refusals(limits, cameras, Target(np.eye(4), box.extents), floor_to_world=world)
        allowed &= [reason is None for reason in reasons]
    return tuple(allowed.tolist())

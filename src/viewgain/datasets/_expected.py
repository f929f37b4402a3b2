"""What each station is expected to be worth for the volume of the true box: targets that need no scan of any candidate."""

import numpy as np

from viewgain.arrays import Array, Pose, Poses
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.plan import expected_error, fused_expected_error, showing

ALONE, FUSED = "volume_alone", "volume_fused"
"""Names of the targets: minus the expected |relative volume error| of a scan alone, and of one fused with the present one."""


def volume_alone(box: Box, stations: Poses, camera: Sensor) -> Array:
    """Return (V,) minus the expected error of a scan from each station; box and stations in the world."""
    return -np.array([expected_error(box, station, camera) for station in stations])


def volume_fused(box: Box, present: Pose, stations: Poses, camera: Sensor) -> Array:
    """Return (V,) minus the expected error after fusing a scan from each station with one from ``present``; all in the world."""
    to_present = inverse(present)
    here = box.in_frame(to_present)
    first = showing(here, np.eye(4), camera, 1.0)
    return -np.array([fused_expected_error(here, first, to_present @ station, camera) for station in stations])

"""What each station is expected to be worth for the volume of the true box: targets that need no scan of any candidate."""

import numpy as np

from viewgain.arrays import Array, Pose, Poses
from viewgain.box import PARAMETERS, Box
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.measure import SYSTEMATIC, Knowledge
from viewgain.plan import Belief, ExpectedErrorPolicy, showing

ALONE, FUSED = "volume_alone", "volume_fused"
"""Names of the targets: minus the expected |relative volume error| of a scan alone, and of one fused with the present one."""


def volume_alone(box: Box, stations: Poses, camera: Sensor) -> Array:
    """Return (V,) minus the expected error of a scan from each station; box and stations in the world."""
    nothing = Knowledge(np.zeros((PARAMETERS, PARAMETERS)), np.zeros((PARAMETERS, SYSTEMATIC)))
    return -_errors(box, nothing, stations, camera, fused=False)


def volume_fused(box: Box, present: Pose, stations: Poses, camera: Sensor) -> Array:
    """Return (V,) minus the expected error after fusing a scan from each station with one from ``present``; all in the world."""
    to_present = inverse(present)
    here = box.in_frame(to_present)
    by_present = showing(here, np.eye(4), camera, 1.0).knowledge
    return -_errors(here, by_present, to_present @ stations, camera, fused=True)


def _errors(box: Box, knowledge: Knowledge, cameras: Poses, camera: Sensor, *, fused: bool) -> Array:
    """Return (V,) expected errors for somebody who knows which box it is, and so much of it by measuring; all at once."""
    belief = Belief((box,), knowledge, camera, 1.0, bounded=True)
    return np.asarray(ExpectedErrorPolicy(fused).errors(belief, cameras)[0])

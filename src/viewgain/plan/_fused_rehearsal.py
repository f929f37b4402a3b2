"""A rehearsal of a view that is fused with the scans so far: those are taken anew, of the box that is tried (ours).

What one camera gets wrong it gets wrong in every scan, and fusing does not average it out. So the scans so far are not taken as
they are, which would be of one camera and the rehearsal of another: all scans of a trial are by the camera of that trial.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Pose, Poses
from viewgain.camera import Sensor
from viewgain.errors import ScanError
from viewgain.gain import MISS, measured_volume
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements, measure
from viewgain.plan._rehearsal import Trial, arriving_within
from viewgain.scans import Scan

_BEFORE = 1
"""Stream of the scans so far, beside that of the candidates' scans."""


@dataclass(frozen=True, slots=True, eq=False)
class FusedTrial:
    """A trial in which the scans so far have been taken and measured."""

    trial: Trial
    """The box, the camera, where it arrives."""
    known: tuple[Measurement, ...]
    """What each of the scans so far says; those that say nothing are missing."""
    believed: Poses
    """(V, 4, 4) where a camera at each candidate believes to be, in its own frame."""
    sensor: Sensor
    """The camera as whoever measures knows it."""
    pose_sigma: tuple[float, float]
    """Standard deviation of those beliefs, metres and radians per axis."""

    def outcome(self, index: int, camera_to_current: Pose) -> float:
        """Return the cost, 0 to 1, of the volume that the scans so far and one from candidate ``index`` give when fused.

        Args:
            index: Which candidate.
            camera_to_current: (4, 4) its pose.
        """
        trial = self.trial
        scan = trial.scan(camera_to_current @ trial.arrived[index], np.random.default_rng(trial.seed))
        added = _measured(scan, self.believed[index], self.sensor)
        both = [*self.known, *(() if added is None else (added,))]
        return trial.cost(lambda: measured_volume(fuse_measurements(both, pose_sigma=self.pose_sigma))) if both else MISS


def fused_trial(trial: Trial, cameras: Poses, sensor: Sensor, pose_sigma: tuple[float, float] = POSE_SIGMA) -> FusedTrial:
    """Return a trial with the scans so far.

    Args:
        trial: What is tried.
        cameras: (k, 4, 4) ``camera_to_current`` of the scans so far, one or more.
        sensor: The camera as whoever measures knows it.
        pose_sigma: How far the belief about a camera's pose is from the truth, standard deviation per axis, metres and radians.
    """
    rng = np.random.default_rng([trial.seed, _BEFORE])
    misses = arriving_within(len(cameras) + len(trial.arrived), pose_sigma)(rng)
    before, believed = misses[: len(cameras)], misses[len(cameras) :]
    scans = [trial.scan(camera, rng) for camera in cameras]
    measured = [_measured(scan, miss, sensor) for scan, miss in zip(scans, before, strict=True)]
    return FusedTrial(trial, tuple(each for each in measured if each is not None), believed, sensor, pose_sigma)


def _measured(scan: Scan | None, miss: Pose, sensor: Sensor) -> Measurement | None:
    """Return what a scan says, from a camera that believes to be off by ``miss``, in its own frame; None: nothing."""
    if scan is None or scan.camera_to_world is None:
        return None
    try:
        return measure(scan.posed(scan.camera_to_world @ miss), camera=sensor)
    except (ScanError, np.linalg.LinAlgError):
        return None

"""Relative volume error of one scan by an estimator of ``viewgain.gain``, with the true box told from what else stands there."""

from dataclasses import replace

import numpy as np

from viewgain.camera import Sensor
from viewgain.datasets._sample import Sample
from viewgain.errors import ViewgainError
from viewgain.gain import measured_volume, volume_estimator
from viewgain.measure import Measurement, measure
from viewgain.scans import Scan


def volume_error(name: str, scan: Scan, sample: Sample, camera: Sensor | None) -> float:
    """Return the relative volume error V / V* - 1 of one scan; NaN without an estimate, or where the truth is not known.

    Of several boxes that the default estimator finds, the one nearest to the true one counts if it lies within its half diagonal;
    where the truth's place is not known, the largest in the image. The others look at the middle of the image.

    Args:
        name: One of ``viewgain.gain.ESTIMATORS``.
        scan: The whole scan.
        sample: The sample that was made of it, with the truth.
        camera: The camera, where it is known.
    """
    truth = float(np.prod(sample.dims))
    if not np.isfinite(truth):
        return float("nan")
    try:
        if name == "default":
            return measured_volume(_of_object(measure(scan, camera=camera), sample)) / truth - 1
        return volume_estimator(name)(scan) / truth - 1
    except (ViewgainError, np.linalg.LinAlgError):  # a miss is a miss, whatever its name
        return float("nan")


def _of_object(measured: Measurement, sample: Sample) -> Measurement:
    """Return the measurement with only the box that is the sample's, or as it is where nobody knows where that stands."""
    if not measured.boxes or not np.all(np.isfinite(sample.object_to_camera)):
        return measured
    centre = sample.object_to_camera[:3, 3] + sample.object_to_camera[:3, 2] * sample.dims[2] / 2
    away = [float(np.linalg.norm(box.box.centre - centre)) for box in measured.boxes]
    nearest = int(np.argmin(away))
    within = away[nearest] <= np.linalg.norm(sample.dims) / 2
    return replace(measured, boxes=(measured.boxes[nearest],) if within else ())

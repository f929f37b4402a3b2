"""Estimators of a box's volume by name, each as one function: scan and truth in, relative error out."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from viewgain.camera import Sensor
from viewgain.datasets._sample import Sample
from viewgain.errors import ViewgainError
from viewgain.measure import measure
from viewgain.planes import AS_PUBLISHED, MENDED, Settings, measure_lines
from viewgain.scans import Scan

Estimator: TypeAlias = Callable[[Scan, Sample, Sensor | None], float]
"""Volume of the sample's box, cubic metres; NaN without an estimate."""


def volume_error(name: str, scan: Scan, sample: Sample, camera: Sensor | None) -> float:
    """Return the relative volume error V / V* - 1 of one scan; NaN without an estimate, or where the truth is not known.

    Args:
        name: A key of :data:`ESTIMATORS`.
        scan: The whole scan.
        sample: The sample that was made of it, with the truth.
        camera: The camera, where it is known.
    """
    truth = float(np.prod(sample.dims))
    if not np.isfinite(truth):
        return float("nan")
    try:
        return ESTIMATORS[name](scan, sample, camera) / truth - 1
    except (ViewgainError, np.linalg.LinAlgError):  # a miss is a miss, whatever its name
        return float("nan")


def _lines(settings: Settings) -> Estimator:
    def estimate(scan: Scan, sample: Sample, camera: Sensor | None) -> float:
        del sample, camera
        volume = measure_lines(scan, settings).volume
        return float("nan") if volume is None else volume

    return estimate


def _likelihood(scan: Scan, sample: Sample, camera: Sensor | None) -> float:
    """Return the volume of the box nearest to the true one (within its half diagonal), or the largest where that is not known."""
    boxes = measure(scan, camera=camera).boxes
    if not boxes:
        return float("nan")
    if not np.all(np.isfinite(sample.object_to_camera)):
        return boxes[0].volume
    true_centre = sample.object_to_camera[:3, 3] + sample.object_to_camera[:3, 2] * sample.dims[2] / 2
    away = [float(np.linalg.norm(box.box.centre - true_centre)) for box in boxes]
    nearest = int(np.argmin(away))
    return boxes[nearest].volume if away[nearest] <= np.linalg.norm(sample.dims) / 2 else float("nan")


ESTIMATORS: Mapping[str, Estimator] = MappingProxyType(
    {"lines_published": _lines(AS_PUBLISHED), "lines_mended": _lines(MENDED), "likelihood": _likelihood}
)
"""The paper's estimator as its program is published, the same mended (docs/lines.md), and the default one (docs/measuring.md)."""

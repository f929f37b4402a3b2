"""Who estimates a box's volume: a function from scan to volume, NaN for none. By name, so that a recipe can choose."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.measure import Measurement, measure
from viewgain.scans import Scan

VolumeEstimator: TypeAlias = Callable[[Scan], float]
"""A scan of one box to its volume, cubic metres; NaN for no estimate. The same scan must give the same answer."""
ESTIMATORS = ("default", "lines_published", "lines_mended", "corners_published", "corners_mended")
"""Names that :func:`volume_estimator` knows: our own, and the source paper's in its four forms (docs/lines.md)."""


def volume_estimator(name: str, camera: str | Sensor | None = None) -> VolumeEstimator:
    """Return an estimator by name.

    Args:
        name: "default" (:func:`viewgain.measure.measure`), or another of :data:`ESTIMATORS`.
        camera: The camera of the scans, as far as it is known; for "default" only.

    Raises:
        ConfigError: If there is no such estimator.
    """
    if name == "default":
        return lambda scan: measured_volume(measure(scan, camera=camera))
    if name not in ESTIMATORS:
        raise ConfigError(f"estimator: got {name!r}, wanted one of {', '.join(ESTIMATORS)}")
    # The planner stands on this room, and plain measuring on the planner's words: neither need load planes.
    from viewgain.planes import AS_PUBLISHED, MENDED, measure_lines

    method, form = name.split("_")
    settings = AS_PUBLISHED if form == "published" else MENDED
    settings = settings.using("corners") if method == "corners" else settings
    return lambda scan: _or_nan(measure_lines(scan, settings).volume)


def measured_volume(measured: Measurement) -> float:
    """Return the volume of the box that is largest in the image, cubic metres; NaN for none, or with an open dimension.

    An open dimension has a lower bound and no value, so the volume is a bound and no estimate.
    """
    if not measured.boxes or any(measured.boxes[0].is_open):
        return float("nan")
    return measured.boxes[0].volume


def _or_nan(volume: float | None) -> float:
    return float(np.nan) if volume is None else volume

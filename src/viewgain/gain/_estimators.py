"""Who estimates a box's volume: a function from scan to volume, NaN for none. By name, so that a recipe can choose."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.measure import Measurement, measure
from viewgain.planes import AS_PUBLISHED, MENDED, Settings, measure_lines
from viewgain.scans import Scan

VolumeEstimator: TypeAlias = Callable[[Scan], float]
"""A scan of one box to its volume, cubic metres; NaN for no estimate. The same scan must give the same answer."""
LINE_SETTINGS: dict[str, Settings] = {
    "lines_published": AS_PUBLISHED,
    "lines_mended": MENDED,
    "corners_published": AS_PUBLISHED.using("corners"),
    "corners_mended": MENDED.using("corners"),
}
"""The source paper's estimator in its four forms (docs/lines.md)."""
ESTIMATORS = ("default", *LINE_SETTINGS)
"""Names that :func:`volume_estimator` knows."""


def volume_estimator(name: str, camera: str | Sensor | None = None) -> VolumeEstimator:
    """Return an estimator by name.

    Args:
        name: "default" (:func:`viewgain.measure.measure`), or a key of :data:`LINE_SETTINGS`.
        camera: The camera of the scans, as far as it is known; for "default" only.

    Raises:
        ConfigError: If there is no such estimator.
    """
    if name == "default":
        return lambda scan: measured_volume(measure(scan, camera=camera))
    if name not in LINE_SETTINGS:
        raise ConfigError(f"estimator: got {name!r}, wanted one of {', '.join(ESTIMATORS)}")
    settings = LINE_SETTINGS[name]
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

"""The volume error of many scans of one box: what a histogram is filled with."""

from collections.abc import Iterable

import numpy as np

from viewgain.arrays import Array, Vector
from viewgain.gain._estimators import VolumeEstimator, measured_volume
from viewgain.gain._station_scans import BoxScans, believed_scan
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements, measure


def volume_errors(scans: BoxScans, estimator: VolumeEstimator, numbers: Iterable[int]) -> Array:
    """Return the (V, n) relative volume errors V / V* - 1 of scans from every station, each measured alone; NaN for a miss.

    Args:
        scans: The box and its scans.
        estimator: Who measures, of :func:`viewgain.gain.volume_estimator` or your own.
        numbers: Which n scans of each station, e.g. ``range(700)``.
    """
    chosen = list(numbers)
    errors = np.full((scans.views, len(chosen)), np.nan)
    for view in range(scans.views):
        for column, number in enumerate(chosen):
            scan = scans.scan(view, number)
            errors[view, column] = np.nan if scan is None else estimator(scan) / scans.box.volume - 1
    return errors


def fused_errors(
    scans: BoxScans, present: int, numbers: Iterable[int], *, pose_sigma: tuple[float, float] | None = POSE_SIGMA
) -> tuple[Array, Vector]:
    """Return the volume errors of every station's scans, each fused with one from the present station (the default estimator).

    For each number a first scan is taken at the present station; scan ``number`` of every station is then fused with it. From the
    present station itself that is a second scan from there, its own jitter and noise, so that staying is a candidate too.

    Args:
        scans: The box and its scans.
        present: The present station.
        numbers: Which n scans of each station.
        pose_sigma: The camera's pose is believed to be off by errors drawn with these standard deviations (metres and radians per
            axis), and fused as such; None fuses without poses, by what the scans show.

    Returns:
        (V, n) relative volume errors after fusing, NaN for a miss; (n,) those of the first scans alone.

    Raises:
        ConfigError: If there is no such station.
    """
    chosen = list(numbers)
    errors, alone = np.full((scans.views, len(chosen)), np.nan), np.full(len(chosen), np.nan)
    for column, number in enumerate(chosen):
        # Odd numbers are first scans, even ones are candidates: no scan is fused with itself.
        first = measured_scan(scans, present, 2 * number + 1, pose_sigma)
        alone[column] = _error(scans, first)
        for view in range(scans.views):
            second = measured_scan(scans, view, 2 * number, pose_sigma)
            both = [each for each in (first, second) if each is not None]
            if both:
                errors[view, column] = _error(scans, fuse_measurements(both, pose_sigma=pose_sigma or POSE_SIGMA))
    return errors, alone


def measured_scan(
    scans: BoxScans, view: int, number: int, pose_sigma: tuple[float, float] | None = POSE_SIGMA
) -> Measurement | None:
    """Return the default estimator's measurement of :func:`believed_scan`; arguments and errors as there."""
    scan = believed_scan(scans, view, number, pose_sigma)
    return None if scan is None else measure(scan, camera=scans.sensor)


def _error(scans: BoxScans, measured: Measurement | None) -> float:
    return float("nan") if measured is None else measured_volume(measured) / scans.box.volume - 1

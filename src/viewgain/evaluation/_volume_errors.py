"""What every position of a rig is worth for measuring one box: what planners are held to."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ViewgainError
from viewgain.evaluation._volume_case import VolumeCase
from viewgain.gain import VolumeEstimator, measured_scan, measured_volume, volume_estimator
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements
from viewgain.scans import Scan
from viewgain.simulate import draw_range_error

_OTHERS = 0x7635
"""Stream of other cameras."""


def case_errors(case: VolumeCase) -> Array:
    """Return (V, 2n) relative volume errors: n scans of each position that score it, then n that are the oracle's.

    NaN for a miss, and for positions that cannot be reached. Fused, each scan is joined with the one to decide by,
    always the same: what is asked is what this very decision is worth.
    """
    return errors_of_scans(case, range(2 * case.settings.captures))


def errors_of_scans(case: VolumeCase, numbers: Iterable[int]) -> Array:
    """Return (V, k) relative volume errors of k scans of each position, named by number, as :func:`case_errors` has them."""
    settings, chosen = case.settings, list(numbers)
    errors = np.full((case.scans.views, len(chosen)), np.nan)
    if settings.fused:
        known = _or_none(case, case.present, 2 * settings.captures)
        for view in np.flatnonzero(case.reachable).tolist():
            errors[view] = [_fused_error(case, known, view, number) for number in chosen]
        return errors
    measured = _never_failing(volume_estimator(settings.estimator, case.camera))
    for view in np.flatnonzero(case.reachable).tolist():
        for column, number in enumerate(chosen):
            scan = case.scans.scan(view, number)
            errors[view, column] = np.nan if scan is None else measured(scan) / case.box.volume - 1
    return errors


def errors_by_others(case: VolumeCase) -> Array:
    """Return (V, n) errors as :func:`case_errors` has them, but of scans by n other cameras of the model, one scan each.

    Each camera has a systematic error of its own, drawn as the case's is. Fused, it takes the scan to decide by as well. Who
    chooses by these knows all about the box, and about the camera what its data sheet says.
    """
    rng = np.random.default_rng([case.settings.seed, _OTHERS, case.number])
    columns = []
    for k in range(case.settings.captures):
        scans = replace(case.scans, error=draw_range_error(case.camera, rng=rng))
        columns.append(errors_of_scans(replace(case, scans=scans), [2 * case.settings.captures + 1 + k]))
    return np.concatenate(columns, axis=1)


def _fused_error(case: VolumeCase, known: Measurement | None, view: int, number: int) -> float:
    both = [each for each in (known, _or_none(case, view, number)) if each is not None]
    if not both:
        return float("nan")
    try:
        return measured_volume(fuse_measurements(both)) / case.box.volume - 1
    except (ViewgainError, np.linalg.LinAlgError):  # a miss is a miss, whatever its name
        return float("nan")


def _or_none(case: VolumeCase, view: int, number: int) -> Measurement | None:
    try:
        return measured_scan(case.scans, view, number, POSE_SIGMA)
    except (ViewgainError, np.linalg.LinAlgError):
        return None


def _never_failing(estimator: VolumeEstimator) -> VolumeEstimator:
    def measured(scan: Scan) -> float:
        try:
            return estimator(scan)
        except (ViewgainError, np.linalg.LinAlgError):  # a miss is a miss, whatever its name
            return float("nan")

    return measured

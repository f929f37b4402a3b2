"""What scans of a box of known size say about one camera's systematic error: scale and offset of its ranges (ours).

A scale or offset error of all ranges moves the measured extents by a known amount (the systematic gradient of the likelihood
carried through its information). With the true extents given, that is a linear model of two unknowns, and the error's posterior
is normal: prior from the camera's data sheet, one row per bounded extent.
"""

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from viewgain.arrays import Array, Vector3
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.measure._measure import measure
from viewgain.measure._result import BoxEstimate
from viewgain.measure._uncertainty import COMMON_EDGES, LOOSE_PRIOR
from viewgain.scans import Scan

OTHER_BOX = 6.0
"""An extent that is off by more than this many standard deviations, systematic part included, belongs to another box."""


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """One camera's range error r -> r (1 + scale) + offset, as scans of a known box show it."""

    sensor: Sensor
    """The camera with what was learned: its known error, and the standard deviations that remain."""
    before: Sensor
    """The camera as it was."""
    mean: Array
    """(2,) scale, and offset in metres, beyond what ``before`` already corrects."""
    covariance: Array
    """(2, 2) of the two."""
    extents: int
    """How many measured extents it rests on."""
    scans: int
    """How many scans."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form."""
        return {
            "camera": self.before.name,
            "scans": self.scans,
            "extents": self.extents,
            "scale": round(self.sensor.scale, 6),
            "scale_sd": round(self.sensor.scale_sd, 6),
            "offset_m": round(self.sensor.offset, 6),
            "offset_sd_m": round(self.sensor.offset_sd, 6),
            "before": {"scale_sd": self.before.scale_sd, "offset_sd_m": self.before.offset_sd},
        }


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Linear equations for scale and offset from one scan."""

    error: Array
    """(m,) measured minus true extents, metres."""
    response: Array
    """(m, 2) metres per unit of scale and per metre of offset."""
    noise: Array
    """(m, m) covariance of the extents without systematic error."""


def calibrate(scans: list[Scan], dims: Vector3, camera: Sensor, *, floor: Scan | None = None) -> Calibration:
    """Return what ``scans`` of a box with sides ``dims`` say about the systematic error of ``camera``.

    Args:
        scans: At least one; the largest box in each is taken for the known one, and views from several distances and sides tell
            scale from offset.
        dims: (3,) true side lengths in any order, metres, positive.
        camera: The camera with the prior (scale_sd, offset_sd).
        floor: As in :func:`measure`.

    Returns:
        The posterior; never wider than the prior. Bounded extents count, open ones say nothing.

    Raises:
        ConfigError: If ``dims`` are not three positive lengths, a scan shows no box, or a box that no such error explains.
    """
    dims = np.asarray(dims, dtype=float)
    if dims.shape != (3,) or not np.all(np.isfinite(dims)) or np.any(dims <= 0):
        raise ConfigError(f"calibrate: got sides {dims.tolist()}, wanted three positive lengths in metres")
    if not scans:
        raise ConfigError("calibrate: got no scan, wanted at least one of the known box")
    rows = [_rows(scan, dims, camera, floor) for scan in scans]
    prior = np.diag(1 / np.maximum([camera.scale_sd, camera.offset_sd], 1e-9) ** 2)
    precision, pull = prior.copy(), np.zeros(2)
    for row in rows:
        weighted = row.response.T @ np.linalg.inv(row.noise)
        precision += weighted @ row.response
        pull += weighted @ row.error
    covariance = np.linalg.inv(precision)
    mean = covariance @ pull
    scale_sd, offset_sd = np.sqrt(np.diag(covariance))
    learned = camera.corrected(float(mean[0]), float(mean[1]), float(scale_sd), float(offset_sd))
    return Calibration(learned, camera, mean, covariance, sum(len(row.error) for row in rows), len(scans))


def _rows(scan: Scan, dims: Vector3, camera: Sensor, floor: Scan | None) -> _Rows:
    result = measure(scan, camera=camera, floor=floor)
    if not result.boxes:
        raise ConfigError(f"calibrate: {scan.source}: got no box ({result.reason}), wanted a scan of the known box")
    box = result.boxes[0]
    closed = np.flatnonzero(~np.array(box.is_open))
    spread = np.linalg.inv(box.knowledge.information + LOOSE_PRIOR)
    response = (spread @ box.knowledge.systematic)[6:][closed]
    others = response[:, 2:] * (*camera.systematic_sd[2:], COMMON_EDGES)
    noise = (box.knowledge.inflation * camera.spread**2 * spread[6:, 6:])[np.ix_(closed, closed)] + others @ others.T
    truth = _matched(box, dims)
    error = (box.box.extents - truth)[closed]
    _check(scan, box, error / np.sqrt(np.diag(box.covariance)[6:][closed]), dims)
    return _Rows(error, response[:, :2], np.asarray(noise, dtype=float))


def _matched(box: BoxEstimate, dims: Vector3) -> Vector3:
    """Return the true sides in the order of the box's axes: the order that fits best, open extents being bounds."""
    own, opened = box.box.extents, np.array(box.is_open)
    orders = [dims[list(order)] for order in permutations(range(3))]
    return min(orders, key=lambda true: float(np.sum(np.where(opened, np.maximum(own - true, 0.0), own - true) ** 2)))


def _check(scan: Scan, box: BoxEstimate, sigmas: Array, dims: Vector3) -> None:
    if len(sigmas) and np.max(np.abs(sigmas)) > OTHER_BOX:
        measured, known = (" x ".join(f"{1e3 * side:.0f}" for side in sides) for sides in (box.dimensions, np.sort(dims)[::-1]))
        raise ConfigError(
            f"calibrate: {scan.source}: got a box of {measured} mm, wanted the known one of {known} mm; no camera error explains"
            " the difference: is it another box, or are the sides in another unit?"
        )

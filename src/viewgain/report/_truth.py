"""What was measured beside what is true: which measured dimension is which side of the true box, and how far off it is."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Indices, Pose, Vector3
from viewgain.box import Box
from viewgain.measure import BoxEstimate, Measurement

SIDES = ("Length", "Width", "Height")
"""The sides of the true box from the longest to the shortest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """One measured number beside the true one, in metres or cubic metres."""

    name: str
    """Length, Width, Height or Volume."""
    upright: bool
    """Whether it is the vertical dimension."""
    value: float
    """The estimate; a lower bound where it is open."""
    sigma: float | None
    """Its standard deviation; None where nothing bounds it."""
    low: float
    """Lower end of the 90 % interval."""
    high: float | None
    """Upper end of the 90 % interval; None where nothing bounds it."""
    basis: str
    """seen, inferred or open; empty for the volume."""
    true: float
    """The truth."""

    @property
    def relative_error(self) -> float:
        """Signed error over the truth."""
        return self.value / self.true - 1

    @property
    def is_open(self) -> bool:
        """Whether the estimate is only a lower bound."""
        return self.basis == "open"

    @property
    def covered(self) -> bool:
        """Whether the 90 % interval holds the truth."""
        return self.low <= self.true and (self.high is None or self.true <= self.high)


def true_order(truth: Box) -> Indices:
    """Return (3,) axes of the true box from its longest to its shortest side."""
    return np.argsort(-truth.extents, kind="stable")


def true_dimensions(truth: Box) -> Vector3:
    """Return (3,) true length >= width >= height, metres."""
    return np.asarray(truth.extents[true_order(truth)])


def true_axes(estimate: BoxEstimate, camera_to_world: Pose, truth: Box) -> Indices:
    """Return (3,) for the measured box's x, y and z the axis of the true box along which it lies.

    Sides are told apart by direction and not by size: a side that is only seen in part would else pass for another one.

    Args:
        estimate: The measured box, camera frame.
        camera_to_world: (4, 4) pose of the camera.
        truth: The true box, world frame.
    """
    measured = camera_to_world[:3, :3] @ estimate.box.box_to_camera[:3, :3]
    agreement = np.abs(measured.T @ truth.box_to_camera[:3, :3])
    straight = agreement[0, 0] + agreement[1, 1] >= agreement[0, 1] + agreement[1, 0]
    return np.array([0, 1, 2] if straight else [1, 0, 2])


def true_of_reported(estimate: BoxEstimate, camera_to_world: Pose, truth: Box) -> Vector3:
    """Return (3,) the true side that belongs to each reported dimension, in the order of ``estimate.dimensions``, metres."""
    return np.asarray(truth.extents[true_axes(estimate, camera_to_world, truth)[estimate.order]])


def compared(measurement: Measurement, truth: Box) -> tuple[Compared, ...]:
    """Return length, width, height and volume of the first measured box beside the truth; nothing if none was measured.

    Args:
        measurement: What was measured.
        truth: The true box, world frame.
    """
    if not measurement.boxes:
        return ()
    estimate = measurement.boxes[0]
    axis_of = true_axes(estimate, measurement.world, truth)[estimate.order]
    rows = []
    for name, axis in zip(SIDES, true_order(truth), strict=True):
        k = int(np.flatnonzero(axis_of == axis)[0])
        low, high = estimate.interval90[k]
        rows.append(Compared(
            name=name, upright=bool(axis == 2), value=float(estimate.dimensions[k]), sigma=estimate.sigma[k], low=low, high=high,
            basis=estimate.basis[k], true=float(truth.extents[axis]),
        ))  # fmt: skip
    low, high = estimate.volume_interval90
    basis = "open" if any(estimate.is_open) else ""
    return (*rows, Compared(
        name="Volume", upright=False, value=estimate.volume, sigma=estimate.volume_sigma, low=low, high=high, basis=basis,
        true=truth.volume,
    ))  # fmt: skip

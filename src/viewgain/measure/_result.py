"""What measuring returns: boxes with error bars and flags, or a machine-readable reason; and its JSON form."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Array, Indices, Pose, Vector3
from viewgain.box import FACES, Box
from viewgain.camera import Sensor
from viewgain.geometry import floor_to_camera, inverse, pose
from viewgain.measure._fit import View
from viewgain.measure._floor import Floor
from viewgain.measure._quality import Quality
from viewgain.measure._uncertainty import Z90, Interval, Knowledge

SCHEMA = 1
"""Version of the JSON form; it grows by new keys only."""
MICROMETRES, CUBIC_MILLIMETRES = 6, 9
"""Decimals of metres and cubic metres as they are written."""
REASONS = {
    "no_floor": "no plane in the scan can be a floor; show more of the floor, or give an empty scene with --floor",
    "nothing_on_floor": "nothing stands on the floor; is the box lower than 1.5 cm, or out of range?",
    "not_a_box": "what stands on the floor does not fit a box",
    "tilted": "a part of the object neither lies flat nor stands upright; only boxes that stand on a face are measured",
    "cut_by_border": "the object leaves the image on so many sides that no dimension can be bounded; move back",
    "too_few_points": "what stands on the floor has too few returns to measure; move closer",
}
"""Why a scan gave no box, and what to do about it."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxEstimate:
    """One measured box: the estimate, its uncertainty, and what the camera saw of it."""

    box: Box
    """Pose and extents at the maximum of the likelihood, in the camera frame of the (last) scan."""
    knowledge: Knowledge
    """What the scans say about the box; a further view adds to it."""
    covariance: Array
    """(9, 9) covariance of a step of the box (Box.moved): noise and systematic error."""
    intervals: tuple[Interval, Interval, Interval]
    """90 % intervals of the extents along the box's x, y and z."""
    quality: Quality
    """Faces seen and share of the evidence explained."""
    flags: tuple[str, ...]
    """cut, open, grazing, bent, few_points, touching, flaps, ambiguous, stacked."""
    views: tuple[View, ...]
    """The evidence, for fusing with further scans."""

    def in_frame(self, reference_to_new: Pose) -> "BoxEstimate":
        """Return the estimate in another camera's frame: the box, and from where it was seen.

        Args:
            reference_to_new: (4, 4) pose of the present reference camera in the new one.
        """
        return replace(
            self, box=self.box.in_frame(reference_to_new), views=tuple(view.in_frame(reference_to_new) for view in self.views)
        )

    @property
    def order(self) -> Indices:
        """(3,) box axes from the longest to the shortest reported dimension."""
        return np.argsort(-self._values(), kind="stable")

    @property
    def dimensions(self) -> Array:
        """(3,) length >= width >= height, metres; an open dimension is its lower bound."""
        return self._values()[self.order]

    @property
    def sigma(self) -> tuple[float | None, ...]:
        """Standard deviation of each dimension, metres; None where nothing bounds it."""
        return tuple(_finite(self.intervals[axis].sigma) for axis in self.order)

    @property
    def interval90(self) -> tuple[tuple[float, float | None], ...]:
        """90 % interval of each dimension, metres; the upper end None where nothing bounds it."""
        return tuple((self.intervals[axis].low, _finite(self.intervals[axis].high)) for axis in self.order)

    @property
    def vertical(self) -> int:
        """Which of the reported dimensions is the vertical one."""
        return int(np.flatnonzero(self.order == 2)[0])

    @property
    def is_open(self) -> tuple[bool, bool, bool]:
        """For the box's x, y and z: whether the scan leaves that extent open."""
        value = self.box.extents
        return tuple(bool(interval.high - value[k] > 2 * Z90 * 0.15 * value[k]) or bool(np.isinf(interval.high))
                     for k, interval in enumerate(self.intervals))  # type: ignore[return-value]  # fmt: skip

    @property
    def volume(self) -> float:
        """Volume, cubic metres; a lower bound if a dimension is open."""
        return float(np.prod(self.dimensions))

    @property
    def volume_sigma(self) -> float | None:
        """Standard deviation of the volume, cubic metres; None if nothing bounds it."""
        if any(np.isnan(interval.sigma) for interval in self.intervals):
            return None
        return self.volume * self._relative_sigma()

    @property
    def volume_interval90(self) -> tuple[float, float | None]:
        """90 % interval of the volume, cubic metres: log-normal, or from the dimensions' own intervals where one is open."""
        if not any(self.is_open):
            factor = float(np.exp(Z90 * self._relative_sigma()))
            return self.volume / factor, self.volume * factor
        values = self._values()
        below = np.linalg.norm([np.log(v / max(i.low, 1e-3)) for v, i in zip(values, self.intervals, strict=True)])
        above = np.linalg.norm([np.log(i.high / v) for v, i in zip(values, self.intervals, strict=True)])
        return self.volume * float(np.exp(-below)), _finite(self.volume * float(np.exp(above)))

    @property
    def basis(self) -> tuple[str, ...]:
        """For each dimension: seen (a seen face spans it), inferred (from edges and free space only), or open."""
        seen = {face.name for face in self.quality.faces if face.seen}
        spanning = ({"+y", "-y", "top"}, {"+x", "-x", "top"}, {"+x", "-x", "+y", "-y", "top"})
        return tuple("open" if self.is_open[axis] else "seen" if seen & spanning[axis] else "inferred" for axis in self.order)

    def oriented(self) -> Pose:
        """Return (4, 4) box_to_camera with its origin at the centre of the reported box and its axes along the dimensions.

        Of an open dimension the lower bound is reported, from the end that was seen: the floor, a seen face, else the nearer one.
        """
        axes = self.box.box_to_camera[:3, :3]
        hidden = self.box.extents - self._values()
        centre = self.box.centre + axes @ (hidden / 2 * [self._seen_end(axis) for axis in range(3)])
        named = axes[:, self.order]
        return pose(named if np.linalg.det(named) > 0 else named * (1.0, 1.0, -1.0), centre)

    def to_dict(self, camera_to_world: Pose) -> dict[str, object]:
        """Return the JSON form of one box (docs/json.md)."""
        return {
            "dimensions_m": _rounded(self.dimensions),
            "sigma_m": [_written(s) for s in self.sigma],
            "interval90_m": [[_written(end) for end in interval] for interval in self.interval90],
            "vertical": self.vertical,
            "volume_m3": _written(self.volume, CUBIC_MILLIMETRES),
            "volume_sigma_m3": _written(self.volume_sigma, CUBIC_MILLIMETRES),
            "volume_interval90_m3": [_written(end, CUBIC_MILLIMETRES) for end in self.volume_interval90],
            "box_to_camera": _rounded(self.oriented()),
            "box_to_world": _rounded(camera_to_world @ self.oriented()),
            "faces_seen": [name for name in FACES if any(face.name == name and face.seen for face in self.quality.faces)],
            "basis": list(self.basis),
            "incidence_deg": {face.name: round(float(np.rad2deg(face.incidence)), 1) for face in self.quality.faces},
            "border_share": round(self.quality.border, 4),
            "flags": list(self.flags),
        }

    def _seen_end(self, axis: int) -> float:
        """Return which end of an axis is known, 1 or -1."""
        if axis == 2:
            return -1.0
        seen = {face.name for face in self.quality.faces if face.seen}
        forward, backward = f"+{'xy'[axis]}" in seen, f"-{'xy'[axis]}" in seen
        if forward != backward:
            return 1.0 if forward else -1.0
        return -1.0 if self.box.box_to_camera[:3, axis] @ self.box.centre > 0 else 1.0

    def _values(self) -> Array:
        """Return (3,) reported extents by box axis: the estimate, or the lower bound of an open one."""
        return np.array([
            interval.low if opened else extent
            for extent, interval, opened in zip(self.box.extents, self.intervals, self.is_open, strict=True)
        ])  # fmt: skip

    def _relative_sigma(self) -> float:
        gradient = np.concatenate([np.zeros(6), 1 / self.box.extents])
        return float(np.sqrt(gradient @ self.covariance @ gradient))


@dataclass(frozen=True, slots=True, eq=False)
class Rejected:
    """An object on the floor that is not reported as a box."""

    reason: str
    """A key of :data:`REASONS`."""
    returns: int
    """How many returns it has."""
    centre: Vector3
    """(3,) mean of its points, metres, camera frame."""
    spread: Vector3
    """(3,) half-extent of its points, metres, camera frame axes."""
    sensor: Sensor
    """The camera that saw it, with the scan's own image."""
    estimate: BoxEstimate | None = None
    """The box that was fitted to it, where it is a box but too little of it is seen; for planning the next view."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/json.md)."""
        return {"reason": self.reason, "returns": self.returns, "centre_camera_m": _rounded(self.centre)}


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """The result of measuring one scan, or several fused: boxes, largest in the image first, or a reason."""

    scans: tuple[str, ...]
    """Where the scans came from."""
    floor: Floor | None
    """The floor, in the camera frame of the (last) scan."""
    boxes: tuple[BoxEstimate, ...]
    """Measured boxes; empty if there is a reason."""
    reason: str | None
    """A key of :data:`REASONS`, or None."""
    rejected: tuple[Rejected, ...] = ()
    """Objects that are not boxes, largest first."""
    camera_to_world: Pose | None = None
    """Pose of the (last) scan's camera, where it was given."""
    notes: tuple[str, ...] = ()
    """What the reader decided about the scans, for the user to check."""
    camera_poses: tuple[Pose | None, ...] = ()
    """Scans fused without poses: the pose of each one's camera in the frame of the boxes, as the joint fit has it (None for a
    scan that shares no box with the others); else empty."""

    @property
    def candidates(self) -> tuple[BoxEstimate, ...]:
        """The boxes, and the rejected objects that would be boxes if more of them were seen."""
        return (*self.boxes, *(rejected.estimate for rejected in self.rejected if rejected.estimate is not None))

    @property
    def world(self) -> Pose:
        """(4, 4) camera_to_world: the given pose's, else the floor's frame with its origin under the camera."""
        if self.camera_to_world is not None:
            return self.camera_to_world
        return np.eye(4) if self.floor is None else inverse(floor_to_camera(self.floor.plane))

    def to_dict(self) -> dict[str, object]:
        """Return the versioned JSON form (docs/json.md)."""
        placed = [None if each is None else _rounded(each) for each in self.camera_poses]
        return {
            "schema": SCHEMA,
            "scans": list(self.scans),
            "floor": floor_json(self.floor),
            "boxes": [box.to_dict(self.world) for box in self.boxes],
            "rejected": [rejected.to_dict() for rejected in self.rejected],
            "reason": self.reason,
            **({"camera_poses": placed} if placed else {}),
        }


def floor_json(floor: Floor | None) -> dict[str, object] | None:
    """Return the JSON form of a floor (docs/json.md); None for none."""
    if floor is None:
        return None
    normal, height = _rounded(floor.plane.normal), round(floor.plane.offset, 5)
    return {"normal_camera": normal, "camera_height_m": height, "spread_m": round(floor.spread, 5)}


def _written(value: float | None, unit: int = MICROMETRES) -> float | None:
    return None if value is None else round(value, unit)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _rounded(array: Array) -> list[object]:
    return np.round(np.asarray(array, dtype=float), MICROMETRES).tolist()  # type: ignore[no-any-return]

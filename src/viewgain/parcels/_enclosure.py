"""What measuring an object of any shape returns, and its JSON form."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask, Pose, Vector3
from viewgain.measure import Floor, floor_json

REASONS = {
    "no_floor": "no plane in the scan can be a floor; show more of the floor, or give an empty scene with --floor",
    "nothing_on_floor": "nothing stands on the floor; is the object lower than 1.5 cm, or out of range?",
    "cut_by_border": "the object leaves the image on so much of its outline that nothing can be bounded; move back",
}
"""Why a scan gave no enclosing box, and what to do about it."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """One length or volume with its 90 % interval, metres or cubic metres."""

    value: float
    """The median of what it may be."""
    low: float
    """Lower end (5 %)."""
    high: float | None
    """Upper end (95 %); None where the object leaves the image or something stands before it, so that nothing bounds it."""
    seen: float
    """The same quantity of the seen points alone: the object is at least about that large."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        high = None if self.high is None else round(self.high, 7)
        return {"value": round(self.value, 7), "interval90": [round(self.low, 7), high], "seen": round(self.seen, 7)}


@dataclass(frozen=True, slots=True, eq=False)
class EnclosingBox:
    """A smallest enclosing box."""

    dimensions: tuple[Estimate, Estimate, Estimate]
    """Standing: length >= width on the floor, then height. Free: in descending order."""
    volume: Estimate
    """Volume of the box; its own estimate, not the product of the others' ends."""
    box_to_camera: Pose
    """(4, 4) pose of the smallest box around the seen points: origin at its centre, axes along the dimensions."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        return {
            "dimensions_m": [estimate.to_dict() for estimate in self.dimensions],
            "volume_m3": self.volume.to_dict(),
            "box_to_camera": np.round(self.box_to_camera, 6).tolist(),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Enclosure:
    """An object of any shape on the floor."""

    upright: EnclosingBox
    """The smallest box that stands on the floor and holds the object."""
    free: EnclosingBox
    """The smallest box in any orientation."""
    hull_volume: Estimate
    """Volume of the convex hull."""
    heap_volume: Estimate
    """Volume between the floor and the topmost surface."""
    box_likeness: float
    """How box-like what is seen is, 0 to 1."""
    flags: tuple[str, ...]
    """cut, hidden, few_points."""
    returns: int
    """How many returns it has."""
    centre: Vector3
    """(3,) mean of its returns, metres, camera frame."""
    mask: Mask
    """(h, w) its pixels in the scan's image."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        return {
            "upright": self.upright.to_dict(),
            "free": self.free.to_dict(),
            "hull_volume_m3": self.hull_volume.to_dict(),
            "heap_volume_m3": self.heap_volume.to_dict(),
            "box_likeness": round(self.box_likeness, 3),
            "flags": list(self.flags),
            "returns": self.returns,
            "centre_camera_m": _rounded(self.centre),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Enclosures:
    """The objects on the floor of one scan, largest in the image first, or a reason."""

    scans: tuple[str, ...]
    """Where the scan came from."""
    floor: Floor | None
    """The floor, camera frame."""
    objects: tuple[Enclosure, ...]
    """The objects; empty if there is a reason."""
    reason: str | None
    """A key of :data:`REASONS`, or None."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        return {
            "schema": 1,
            "scans": list(self.scans),
            "floor": floor_json(self.floor),
            "objects": [found.to_dict() for found in self.objects],
            "reason": self.reason,
        }


def _rounded(array: Array) -> list[object]:
    return np.round(array, 6).tolist()  # type: ignore[no-any-return]

"""Measure whatever it is: as a box where it is one, else by its smallest enclosing box, and say which."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from viewgain.arrays import Array, Mask
from viewgain.box import entry_mask
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.measure import BoxEstimate, Measurement, RangeImage, measure, range_image
from viewgain.parcels._enclose import enclose
from viewgain.parcels._enclosure import Enclosure, Enclosures
from viewgain.parcels._rules import Billed, Rules, billed
from viewgain.scans import Scan

Shape: TypeAlias = Literal["auto", "box", "any"]
"""What an object is taken for: a box where it is one, only boxes, or any shape."""
_SHARED = 0.5
"""An object is a box's if this share of its pixels lies inside the box's outline."""


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """One object, measured as what it is."""

    shape: Literal["box", "any"]
    """Which of the two below it is."""
    box: BoxEstimate | None
    """The box, where it is one."""
    enclosure: Enclosure | None
    """Its enclosing boxes and volumes, where it is not, or where nobody asked."""
    why_no_box: str | None
    """A key of viewgain.measure.REASONS; None for a box, and where boxes were not tried."""
    billed: Billed
    """Dimensions after the parcel rules: of the box, or of the standing enclosing box."""

    def to_dict(self, measurement: Measurement | None) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        box = None if self.box is None or measurement is None else self.box.to_dict(measurement.world)
        return {
            "shape": self.shape,
            "box": box,
            "enclosure": None if self.enclosure is None else self.enclosure.to_dict(),
            "why_no_box": self.why_no_box,
            "billed": self.billed.to_dict(),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Items:
    """Everything on the floor of one scan: boxes first, then the rest, each largest in the image first; or a reason."""

    items: tuple[Item, ...]
    """The objects; empty if there is a reason."""
    reason: str | None
    """A key of viewgain.measure.REASONS, or None."""
    measurement: Measurement | None
    """The measurement of boxes; None with ``shape="any"``."""
    scans: tuple[str, ...]
    """Where the scan came from."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        return {
            "schema": 1,
            "scans": list(self.scans),
            "objects": [item.to_dict(self.measurement) for item in self.items],
            "reason": self.reason,
        }


def measure_any(
    scan: Scan,
    shape: Shape = "auto",
    *,
    camera: str | Sensor | None = None,
    floor: Scan | None = None,
    rules: Rules | None = None,
) -> Items:
    """Measure all objects on the floor of one scan.

    Args:
        scan: The scan, camera frame.
        shape: "auto": boxes where viewgain.measure finds one, enclosing boxes with the reason for what is none; "box": boxes
            only; "any": enclosing boxes for everything.
        camera: Preset name or sensor.
        floor: A scan of the empty scene from the same pose.
        rules: Rounding and dimensional weight; default none.

    Returns:
        The objects, or none and a reason.

    Raises:
        ConfigError: If there is no such shape, or ``camera`` names no preset.
    """
    if shape not in get_args(Shape):
        raise ConfigError(f"got the shape {shape!r}, wanted one of: {', '.join(get_args(Shape))}")
    rules = rules or Rules()
    measured = None if shape == "any" else measure(scan, camera=camera, floor=floor)
    found = None if shape == "box" else enclose(scan, camera=camera, floor=floor)
    boxes = [] if measured is None else [Item("box", box, None, None, billed(box.dimensions, rules)) for box in measured.boxes]
    others = [] if found is None else _others(scan, found, measured, rules)
    items = (*boxes, *others)
    source = measured if measured is not None else found
    reason = None if items or source is None else source.reason
    return Items(items, reason, measured, (scan.source,))


def _others(scan: Scan, found: Enclosures, measured: Measurement | None, rules: Rules) -> list[Item]:
    """Return the objects that no measured box accounts for."""
    image = range_image(scan)
    taken = _in_boxes(image, measured)
    items = []
    for one in found.objects:
        if (one.mask & taken).sum() > _SHARED * one.mask.sum():
            continue
        standing = [estimate.value for estimate in one.upright.dimensions]
        items.append(Item("any", None, one, _why(one, measured), billed(np.array(standing), rules)))
    return items


def _in_boxes(image: RangeImage, measured: Measurement | None) -> Mask:
    """Return the (h, w) pixels inside the outline of any measured box."""
    taken = np.zeros(image.ranges.shape, dtype=bool)
    for box in () if measured is None else measured.boxes:
        taken |= entry_mask(box.box, image.directions.reshape(-1, 3)).reshape(taken.shape)
    return taken


def _why(one: Enclosure, measured: Measurement | None) -> str | None:
    """Return the reason of the rejected object nearest to this one; ``not_a_box`` where none was tried."""
    if measured is None:
        return None
    if not measured.rejected:
        return "not_a_box"

    def away(centre: Array) -> float:
        return float(np.linalg.norm(centre - one.centre))

    return min(measured.rejected, key=lambda refused: away(refused.centre)).reason

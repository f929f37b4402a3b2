"""Parcel rules on the command line: what is billed, in JSON, CSV and words; nothing anywhere without a rule."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from viewgain.arrays import Array
from viewgain.cli._commands import Measure
from viewgain.errors import ConfigError

if TYPE_CHECKING:  # loaded only where a rule is asked for
    from viewgain.parcels import Billed, Rules

BILLED_COLUMNS = (
    "billed_length_m", "billed_width_m", "billed_height_m", "billed_volume_m3", "under_12_divisions", "dimensional_weight_kg",
)  # fmt: skip
LARGEST_UNIT = 0.5
"""A larger unit of rounding is taken for a mistaken millimetre, metres."""


@dataclass(frozen=True, slots=True)
class Bills:
    """What is billed for each object of a result."""

    rules: "Rules | None"
    """The rules; None where none is asked for."""
    each: tuple["Billed", ...]
    """One per object, in order; empty without rules."""

    def json(self, index: int) -> dict[str, object]:
        """Return the key ``billed`` of one object, or no key."""
        return {"billed": self.each[index].to_dict()} if self.each else {}

    def cells(self, index: int) -> list[object]:
        """Return the CSV cells of one object under :data:`BILLED_COLUMNS`, or none."""
        return _cells(self.each[index]) if self.each else []

    def blank(self) -> list[object]:
        """Return empty CSV cells for a row without an object."""
        return [""] * len(BILLED_COLUMNS) if self.rules is not None else []

    def say(self, noun: str) -> None:
        """Print a line per object, and where a division is asked for that this is no certified measurement."""
        for index, bill in enumerate(self.each):
            print(f"{noun} {index}, billed: {_in_words(bill)}")
        if self.rules is not None and self.rules.division is not None and self.each:
            print(f"Rounded to divisions of {1000 * self.rules.division:g} mm; this is not a certified measurement.")


def rules_of(command: Measure) -> "Rules | None":
    """Return the rules that a command asks for; None for none.

    Raises:
        ConfigError: If a number is not positive, or a unit of rounding cannot be in metres.
    """
    if command.division is None and command.round_up is None and command.divisor is None:
        return None
    from viewgain.parcels import Rules

    for option, unit in (("--division", command.division), ("--round-up", command.round_up)):
        if unit is not None and LARGEST_UNIT < unit < float("inf"):
            raise ConfigError(f"got {option} {unit:g}, wanted metres, at most {LARGEST_UNIT:g}; 5 mm are 0.005")
    return Rules(division=command.division, round_up=command.round_up, divisor=command.divisor)


def bills_of(dimensions: Sequence[Array], rules: "Rules | None") -> Bills:
    """Return what is billed for objects of these (3,) dimensions, metres."""
    if rules is None:
        return Bills(None, ())
    from viewgain.parcels import billed

    return Bills(rules, tuple(billed(each, rules) for each in dimensions))


def _cells(bill: "Billed") -> list[object]:
    weight = "" if bill.dimensional_weight is None else f"{bill.dimensional_weight:.6g}"
    return [*(f"{side:.6g}" for side in bill.dimensions), f"{bill.volume:.6g}", int(bill.too_small), weight]


def _in_words(bill: "Billed") -> str:
    parts = [" x ".join(f"{1000 * side:.6g}" for side in bill.dimensions) + f" mm, {1000 * bill.volume:.2f} l"]
    if bill.dimensional_weight is not None:
        parts.append(f"dimensional weight {bill.dimensional_weight:.2f} kg")
    if bill.too_small:
        parts.append("a side is under 12 divisions, too small for this division")
    return "; ".join(parts)

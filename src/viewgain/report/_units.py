"""Numbers as people read them: millimetres for lengths, litres for volumes (cubic metres for large ones), a true minus sign."""

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit to print in."""

    name: str
    """Its sign."""
    per_metre: float
    """How many of it make one metre, or cubic metre."""
    digits: int
    """Decimals."""

    def number(self, value: float) -> str:
        """Return a value, in metres or cubic metres, as a number of this unit."""
        return minus(f"{value * self.per_metre:.{self.digits}f}")

    def finer(self) -> "Unit":
        """Return the unit with one more decimal, for standard deviations."""
        return replace(self, digits=self.digits + 1)

    def signed(self, value: float) -> str:
        """Return a difference with its sign."""
        return minus(f"{value * self.per_metre:+.{self.digits}f}")


MILLIMETRES = Unit("mm", 1000.0, 1)


def volume_unit(volume: float) -> Unit:
    """Return the unit in which boxes of about this volume (cubic metres) have four digits: litres, or cubic metres from 1 m³."""
    name, per_metre = ("litres", 1000.0) if volume < 1.0 else ("m³", 1.0)
    return Unit(name, per_metre, max(3 - math.floor(math.log10(volume * per_metre)), 0))


def percent(share: float, digits: int = 1) -> str:
    """Return a share as a percentage."""
    return minus(f"{100 * share:.{digits}f} %")


def signed_percent(share: float) -> str:
    """Return a relative error as a percentage with its sign."""
    return minus(f"{100 * share:+.1f} %")


def probability(share: float | None) -> str:
    """Return a probability, never as certain as 0 or 1."""
    if share is None:
        return "–"
    return "> 0.999" if share > 0.999 else "< 0.001" if share < 0.001 else f"{share:.3f}"


def minus(text: str) -> str:
    """Return a number with a true minus sign, and zero without one."""
    if text.startswith("-") and not any(sign in "123456789" for sign in text):
        text = text[1:]
    return text.replace("-", "−")

"""A number and its interval."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number and its 95 % interval."""

    value: float
    """The number."""
    low: float
    """Lower end."""
    high: float
    """Upper end."""

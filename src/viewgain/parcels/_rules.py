"""What parcel rules make of three lengths: scale divisions, rounding up, dimensional weight. Arithmetic only.

The names follow OIML R 129 (multi-dimensional measuring instruments): d is the scale division, and the smallest dimension that an
instrument may measure is 12 d. Nothing here says that an instrument meets that recommendation; that takes a certified instrument.
"""

import math
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ConfigError

SMALLEST_IN_DIVISIONS = 12
"""Dimensions under this many scale divisions are marked."""
_EPSILON = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """What to do with measured dimensions; nothing unless asked for."""

    division: float | None = None
    """Scale division d, metres: dimensions are rounded to the nearest multiple; None: not rounded."""
    round_up: float | None = None
    """Then dimensions are rounded up to the next multiple of this, metres, as carriers do; None: not rounded up."""
    divisor: float | None = None
    """Dimensional-weight divisor, cubic centimetres per kilogram (5000 and 6000 are common); None: no dimensional weight."""

    def __post_init__(self) -> None:
        for name in ("division", "round_up", "divisor"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise ConfigError(f"{name}: got {value}, wanted a positive number")


@dataclass(frozen=True, slots=True)
class Billed:
    """Dimensions after the rules."""

    dimensions: tuple[float, float, float]
    """In the order given, metres."""
    volume: float
    """Their product, cubic metres."""
    too_small: bool
    """Whether a dimension is under 12 scale divisions; always False without a division."""
    dimensional_weight: float | None
    """Volume over the divisor, kilograms; None without a divisor."""

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/shapes.md)."""
        return {
            "dimensions_m": [round(value, 6) for value in self.dimensions],
            "volume_m3": round(self.volume, 9),
            "under_12_divisions": self.too_small,
            "dimensional_weight_kg": None if self.dimensional_weight is None else round(self.dimensional_weight, 4),
        }


def billed(dimensions: Array | tuple[float, ...], rules: Rules) -> Billed:
    """Return three dimensions in metres as the rules want them: to the nearest division (half up), then up to the next unit.

    The mark for under 12 divisions goes by the measured dimensions, not by the rounded ones.

    Raises:
        ConfigError: If there are not three finite dimensions that are zero or more.
    """
    measured = np.asarray(dimensions, dtype=float)
    if measured.shape != (3,) or not np.all(np.isfinite(measured)) or np.any(measured < 0):
        raise ConfigError(f"got dimensions {np.array2string(measured)}, wanted three lengths in metres, zero or more")
    too_small = rules.division is not None and bool(measured.min() < SMALLEST_IN_DIVISIONS * rules.division - _EPSILON)
    kept = measured if rules.division is None else _to_nearest(measured, rules.division)
    kept = kept if rules.round_up is None else _up_to(kept, rules.round_up)
    volume = float(np.prod(kept))
    weight = None if rules.divisor is None else volume * 1e6 / rules.divisor
    return Billed((float(kept[0]), float(kept[1]), float(kept[2])), volume, too_small, weight)


def _to_nearest(values: Array, unit: float) -> Array:
    return np.asarray(np.floor(values / unit + 0.5 + _EPSILON) * unit)


def _up_to(values: Array, unit: float) -> Array:
    """Return multiples of ``unit``; what lies on one already (up to a billionth of it) stays."""
    return np.asarray(np.ceil(values / unit - 1e-6) * unit)

"""Every number of a record is finite and has the sign that it must have."""

from dataclasses import fields
from typing import Any

import numpy as np

from viewgain.errors import ConfigError

ANY_SIGN = {"noise_constant", "noise_per_metre", "noise_per_square_metre", "noise_grazing_range_power", "scale", "offset"}
"""Fitted polynomials and powers, whose sum is judged by the record itself, and known errors."""
POSITIVE = {"noise_reflectivity", "wiggle_period", "unambiguous", "modulation_hz", "spread"}
"""Divisors and lengths that cannot be zero; all others may be."""


def check_numbers(record: Any, where: str) -> None:
    """Raise for the first number of a dataclass that makes no sense, by name.

    Raises:
        ConfigError: If a number is none, not finite (``unambiguous`` may be infinite) or has the wrong sign.
    """
    for field in fields(record):
        value = getattr(record, field.name)
        if field.name in ("name", "kind", "intrinsics") or (field.name == "modulation_hz" and value is None):
            continue
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            raise ConfigError(f"{where}: got {field.name} = {value!r}, wanted a number")
        if not (np.isfinite(value) or (field.name == "unambiguous" and value == np.inf)):
            raise ConfigError(f"{where}: got {field.name} = {value}, wanted a finite number")
        if (value < 0 and field.name not in ANY_SIGN) or (value == 0 and field.name in POSITIVE):
            wanted = "more than zero" if field.name in POSITIVE else "zero or more"
            raise ConfigError(f"{where}: got {field.name} = {value}, wanted {wanted}")

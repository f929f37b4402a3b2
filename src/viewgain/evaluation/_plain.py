"""Results as plain values, for JSON."""

from typing import Any

import numpy as np


def finite(value: Any) -> Any:
    """Return plain values with None for what is no finite number: a ratio to an oracle without any error."""
    if isinstance(value, dict):
        return {key: finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [finite(each) for each in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value

"""Exit codes, and how an expected error is told: 0 measured, 2 bad input or usage, 3 nothing measurable (with its reason)."""

import sys

BAD_INPUT = 2
"""Bad input or usage."""
NOTHING_MEASURED = 3
"""No box could be measured, or there is nothing to plan for."""


def print_error(error: Exception) -> None:
    """Print an expected error as one line on stderr."""
    print(f"viewgain: error: {' '.join(str(error).split())}", file=sys.stderr)

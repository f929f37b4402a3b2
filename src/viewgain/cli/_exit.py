"""Exit codes, and how an expected error is told: 0 done, 2 bad input or usage, 3 nothing there (and why), 4 no writing."""

import sys

BAD_INPUT = 2
"""Bad input or usage."""
NOTHING_MEASURED = 3
"""No box could be measured, or there is nothing to plan for."""
DAMAGED = 3
"""``viewgain dataset verify`` found damaged or missing files."""
DIVERGED = 3
"""``viewgain train`` met a gradient that is not finite."""
NOT_WRITTEN = 4
"""A file or a folder cannot be written: the disk is full, or the folder cannot be written to."""


def print_error(error: Exception) -> None:
    """Print an expected error as one line on stderr."""
    print(f"viewgain: error: {' '.join(str(error).split())}", file=sys.stderr)

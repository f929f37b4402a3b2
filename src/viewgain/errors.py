"""What can go wrong, as a small tree; every message says what was got, what was wanted and what to do.

An expected outcome (no box in the scene, no floor in view) is not an error: it is a result with a reason.
"""


class ViewgainError(Exception):
    """Root of every error that viewgain raises on purpose; the command line turns it into one line and exit code 2."""


class ScanError(ViewgainError, ValueError):
    """A scan cannot be read or used: missing, truncated, of the wrong type, empty, or with too few valid points."""


class ConfigError(ViewgainError, ValueError):
    """A setting, a rig file, a camera file or a command-line value makes no sense."""


class MissingExtraError(ViewgainError, ImportError):
    """A feature needs an optional dependency that is not installed."""


class MeshError(ViewgainError, ValueError):
    """A mesh cannot be read or used: missing, empty, without area, with numbers that are not finite, or too large."""


class DataError(ViewgainError, ValueError):
    """A data set cannot be read or continued: missing, unfinished, damaged, or made by another recipe."""


class ModelError(ViewgainError, ValueError):
    """A network file cannot be read or used: missing, damaged, of another program, or at odds with its own card."""


class StorageError(ViewgainError, OSError):
    """A file or a folder cannot be written: the disk is full, or the folder cannot be written to; exit code 4."""


class TrainingError(ViewgainError, RuntimeError):
    """A training run cannot be started, continued or exported: its folder, its checkpoints or its processes are not in order."""


def one_line(error: BaseException) -> str:
    """Return the first line of an exception's text, at most 120 characters; its type where it has none."""
    lines = str(error).strip().splitlines()
    return (lines[0] if lines else type(error).__name__)[:120]


def printable(text: str) -> str:
    """Return ``text`` with a question mark for every line break and other sign that does not print."""
    return "".join(sign if sign.isprintable() else "?" for sign in text)

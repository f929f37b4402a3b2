"""What is known of the positions around one box, and the file that keeps it: errors of scans, which are costly."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viewgain.arrays import Array
from viewgain.evaluation._claim import damaged, kept_text
from viewgain.evaluation._volume_case import VolumeCase, VolumeSettings
from viewgain.evaluation._volume_errors import case_errors, errors_by_others


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Relative volume errors of scans from each position of a box, NaN for a miss."""

    errors: Array
    """(V, 2n): the first n score, the others are the oracle's."""
    by_others: Array | None = None
    """(V, n) of scans by other cameras of the model; None where nobody asked for them."""


def truth_of(case: VolumeCase, known: Truth | None, *, others: bool) -> Truth:
    """Return what is known of a case and, where something is missing, work it out.

    Args:
        case: The box.
        known: What is known.
        others: Whether scans by other cameras are wanted.
    """
    errors = case_errors(case) if known is None else known.errors
    by_others = None if known is None else known.by_others
    return Truth(errors, errors_by_others(case) if others and by_others is None else by_others)


def truth_text(truth: Truth, case: VolumeCase) -> str:
    """Return what is kept of a box: errors, null for a miss, beside what tells a reader which box it is."""
    known = {"box": case.number, "size_m": case.box.extents.tolist(), "present": case.present, "errors": _rows(truth.errors)}
    if truth.by_others is not None:
        known["errors_by_others"] = _rows(truth.by_others)
    return json.dumps(known, allow_nan=False) + "\n"


def kept_truth(file: Path, settings: VolumeSettings) -> Truth | None:
    """Return what is kept of a box; None if there is nothing yet.

    Raises:
        DataError: If the file is damaged.
    """
    text = kept_text(file)
    if text is None:
        return None
    try:
        content = json.loads(text)
        errors = _table(content["errors"])
        by_others = _table(content["errors_by_others"]) if "errors_by_others" in content else None
    except (ValueError, TypeError, KeyError) as error:
        raise damaged(file) from error
    views = len(settings.stations().stations)
    if errors.shape != (views, 2 * settings.captures):
        raise damaged(file)
    if by_others is not None and by_others.shape != (views, settings.captures):
        raise damaged(file)
    return Truth(errors, by_others)


def _rows(errors: Array) -> list[list[float | None]]:
    return [[float(error) if np.isfinite(error) else None for error in row] for row in errors]


def _table(rows: list[list[float | None]]) -> Array:
    return np.array([[np.nan if error is None else float(error) for error in row] for row in rows], dtype=float)

"""What is known of the positions around one box, and the file that keeps it: errors of scans, which are costly."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viewgain.arrays import Array
from viewgain.evaluation._claim import damaged, kept_text
from viewgain.evaluation._plain import finite
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
    """Return what is known of a case: the very same where nothing is missing, else with what is missing worked out.

    Args:
        case: The box.
        known: What is known.
        others: Whether scans by other cameras are wanted.
    """
    if known is None:
        return Truth(case_errors(case), errors_by_others(case) if others else None)
    if others and known.by_others is None:
        return Truth(known.errors, errors_by_others(case))
    return known


def truth_text(truth: Truth, case: VolumeCase) -> str:
    """Return what is kept of a box: errors, null for a miss, beside what tells a reader which box it is."""
    kept = {
        "box": case.number,
        "size_m": case.box.extents.tolist(),
        "present": case.present,
        "errors": truth.errors.tolist(),
    }
    if truth.by_others is not None:
        kept["errors_by_others"] = truth.by_others.tolist()
    return json.dumps(finite(kept), allow_nan=False) + "\n"


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
        errors = np.array(content["errors"], dtype=float)
        by_others = np.array(content["errors_by_others"], dtype=float) if "errors_by_others" in content else None
    except (ValueError, TypeError, KeyError) as error:
        raise damaged(file) from error
    views, captures = len(settings.stations().stations), settings.captures
    if errors.shape != (views, 2 * captures) or (by_others is not None and by_others.shape != (views, captures)):
        raise damaged(file)
    return Truth(errors, by_others)

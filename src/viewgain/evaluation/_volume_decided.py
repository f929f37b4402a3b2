"""Decisions that take long are kept: a race of rehearsals costs what a thousand answers of a formula do.

Quick ones are made anew every time, so that a table always shows what the planners of today do. A kept one stands beside a
fingerprint of the question and of the program, and is taken for these alone.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy

import viewgain
from viewgain.camera import sensor
from viewgain.evaluation._box_results import rig_digest
from viewgain.evaluation._choice import Choice
from viewgain.evaluation._claim import damaged, kept_text
from viewgain.evaluation._volume_case import VolumeSettings

DECISIONS = "decisions"
"""Where a folder of results holds one file per box."""
_KINDS = (".py", ".json", ".toml")
"""Files of the package that a decision may depend on; networks do not rehearse."""


@dataclass(frozen=True, slots=True)
class Decided:
    """One decision, and what it took."""

    choice: Choice
    """Where to go."""
    milliseconds: float
    """CPU time, measuring included, when it was made."""


def decisions_file(folder: Path, number: int) -> Path:
    """Return where a folder of results keeps the decisions on a box."""
    return folder / DECISIONS / f"box{number:05d}.json"


def decided_text(decided: Mapping[str, Decided], fingerprint: str) -> str:
    """Return what is kept of a box: decisions by policy, beside the :func:`fingerprint` that they were made under."""
    kept = {"made_under": fingerprint, "decisions": {name: asdict(each) for name, each in decided.items()}}
    return json.dumps(kept, allow_nan=False) + "\n"


def kept_decisions(file: Path, settings: VolumeSettings, fingerprint: str) -> dict[str, Decided]:
    """Return the decisions that are kept of a box, by policy; none that were made under another fingerprint.

    Args:
        file: :func:`decisions_file`.
        settings: The question.
        fingerprint: That of question and program.

    Raises:
        DataError: If the file is damaged.
    """
    text = kept_text(file)
    if text is None:
        return {}
    try:
        content = json.loads(text)
        if content["made_under"] != fingerprint:
            return {}
        decided = {name: _decided(**each) for name, each in content["decisions"].items()}
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
        raise damaged(file) from error
    if not all(0 <= each.choice.position < len(settings.stations().stations) for each in decided.values()):
        raise damaged(file)
    return decided


def _decided(choice: Mapping[str, Any], milliseconds: float) -> Decided:
    position, has_opinion, margin = choice["position"], choice["has_opinion"], choice["margin"]
    return Decided(Choice(int(position), bool(has_opinion), float(margin)), float(milliseconds))


def fingerprint_of(settings: VolumeSettings) -> str:
    """Return what stands for all that a decision depends on: question, rig, camera, the package's files, numpy and scipy."""
    digest = hashlib.sha256(json.dumps([settings.to_dict(), rig_digest(settings), repr(sensor(settings.camera))]).encode())
    digest.update(f"numpy {np.__version__} scipy {scipy.__version__}".encode())
    root = Path(viewgain.__file__).parent
    for file in sorted(each for each in root.rglob("*") if each.suffix in _KINDS):
        digest.update(f"\n{file.relative_to(root).as_posix()}\n".encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]

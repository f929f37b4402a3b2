"""Decisions that take long are kept: a race of rehearsals costs what a thousand answers of a formula do.

Quick ones are made anew every time, so that a table always shows what the planners of today do. A kept one stands beside a
fingerprint of the question and of the program, and is taken for these alone.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import scipy

import viewgain
from viewgain.camera import sensor
from viewgain.datasets import make_folder, write_whole
from viewgain.evaluation._box_results import rig_digest
from viewgain.evaluation._choice import Choice
from viewgain.evaluation._claim import damaged, kept_text
from viewgain.evaluation._network_choices import policy_key
from viewgain.evaluation._volume_case import VolumeSettings

DECISIONS = "decisions"
"""Where a folder of results holds one file per box."""
_KINDS = (".py", ".json", ".toml")
"""Files of the package that any decision may depend on; a network is told by the key of its policy (:func:`policy_key`)."""


@dataclass(frozen=True, slots=True)
class Decided:
    """One decision, and what it took."""

    choice: Choice
    """Where to go."""
    milliseconds: float
    """CPU time, measuring included, when it was made."""


@dataclass(frozen=True, slots=True)
class Decisions:
    """Those of one run that are kept, in a folder of results; the same policies may run on it elsewhere meanwhile."""

    folder: Path
    """The results."""
    settings: VolumeSettings
    """The question."""
    keys: Mapping[str, str]
    """Policies by name, each with what it is kept under (:func:`policy_key`)."""
    made_under: str
    """The :func:`fingerprint_of` question and program when the run began."""

    @classmethod
    def begun(cls, folder: Path, settings: VolumeSettings, names: Iterable[str]) -> "Decisions":
        """Return the decisions of policies by name; raises StorageError and ModelError (:func:`policy_key`)."""
        make_folder(folder / DECISIONS)
        return cls(folder, settings, {name: policy_key(name) for name in names}, fingerprint_of(settings))

    def known(self, number: int) -> dict[str, Decided]:
        """Return what is kept of a box, by name; raises as :func:`kept_decisions`."""
        kept = self._kept(number)
        return {name: kept[key] for name, key in self.keys.items() if key in kept}

    def keep(self, number: int, made: Mapping[str, Decided]) -> None:
        """Add decisions on a box, by name: but for those made while the program changed, or the file of their network did.

        Nobody could say by which of the two.
        """
        if fingerprint_of(self.settings) != self.made_under:
            return
        news = {self.keys[name]: each for name, each in made.items() if policy_key(name) == self.keys[name]}
        if news:  # another run may have added its own
            text = decided_text({**self._kept(number), **news}, self.made_under)
            write_whole(decisions_file(self.folder, number), text.encode())

    def _kept(self, number: int) -> dict[str, Decided]:
        return kept_decisions(decisions_file(self.folder, number), self.settings, self.made_under)


def decisions_file(folder: Path, number: int) -> Path:
    """Return where a folder of results keeps the decisions on a box."""
    return folder / DECISIONS / f"box{number:05d}.json"


def decided_text(decided: Mapping[str, Decided], fingerprint: str) -> str:
    """Return what is kept of a box: decisions by key, beside what they were made under (:func:`fingerprint_of`)."""
    kept = {"made_under": fingerprint, "decisions": {name: asdict(each) for name, each in decided.items()}}
    return json.dumps(kept, allow_nan=False) + "\n"


def kept_decisions(file: Path, settings: VolumeSettings, fingerprint: str) -> dict[str, Decided]:
    """Return the decisions that are kept of a box, by key; none that were made under another fingerprint.

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
    """Return what stands for all that a decision depends on: question, rig, camera, the package's files, numpy and scipy.

    And onnxruntime, for networks have a say. Not which network: that is for each policy another (:func:`policy_key`).
    """
    digest = hashlib.sha256(json.dumps([settings.to_dict(), rig_digest(settings), repr(sensor(settings.camera))]).encode())
    digest.update(f"numpy {np.__version__} scipy {scipy.__version__} onnxruntime {version('onnxruntime')}".encode())
    root = Path(viewgain.__file__).parent
    for file in sorted(each for each in root.rglob("*") if each.suffix in _KINDS):
        digest.update(f"\n{file.relative_to(root).as_posix()}\n".encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]

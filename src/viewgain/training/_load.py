"""A trained network out of a run's folder."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from viewgain.errors import TrainingError
from viewgain.network import ScoreNetwork, build
from viewgain.training._checkpoint import read_checkpoint
from viewgain.training._folder import RunFolder, RunRecord


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trained:
    """A network that was trained."""

    module: ScoreNetwork
    """With the run's best weights, on the CPU, in evaluation mode."""
    record: RunRecord
    """What the run was."""
    figures: Mapping[str, Any]
    """On the validation objects: ``step``, ``samples``, ``loss``, ``exact``, ``within_0.05``, ..."""


def load_trained(path: Path) -> Trained:
    """Return the network of a run with its best weights.

    Raises:
        TrainingError: If there is no run, it has no best weights yet, or their file is damaged.
    """
    folder = RunFolder(path)
    record = folder.read()
    if not folder.best.exists():
        raise TrainingError(f"{path}: has no best weights yet; go on with it by viewgain train --resume {path}")
    best = read_checkpoint(folder.best)
    module = build(record.recipe.network, generator=torch.Generator().manual_seed(0))
    try:
        module.load_state_dict(dict(best.tensors))
    except RuntimeError as error:
        raise TrainingError(f"{folder.best}: is of another network than run.json says; train anew") from error
    return Trained(module=module.eval(), record=record, figures=best.state)

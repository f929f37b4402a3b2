"""Who decides where to go next, as options of ``viewgain next``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Deciding:
    """Who decides."""

    policy: Literal["model", "network", "combined"] = "model"
    """model: what each view would teach about the box; network: a trained network, of the objective; combined: for volume, the
    mean of the network and of the error that the model expects."""
    model: tuple[Path, ...] = ()
    """Network files made by viewgain export, several for their mean; default the shipped one for the rig and for whether the
    scan has a pose."""
    abstain: float = 0.0
    """With --policy network: name no view where the probability that it is the best is under this; 0 for never."""

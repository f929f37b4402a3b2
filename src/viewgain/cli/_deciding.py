"""Who decides where to go next, as options of ``viewgain next``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Deciding:
    """Who decides."""

    policy: Literal["auto", "model", "expected", "rehearsed", "network", "combined"] = "auto"
    """auto: model where every dimension is bounded, else combined; model: what each view would teach about the box; expected: the
    volume error that is to be expected after it; rehearsed: that error, tried out in simulation (a minute or more), and as
    combined where nothing could be measured; network: a trained network, of the objective; combined: for volume, expected and
    network, by what is known."""
    model: tuple[Path, ...] = ()
    """Network files made by viewgain export, several for their mean; default the shipped one of the objective: for volume the one
    of any rig, for coverage that of the rig and of whether the scan has a pose."""
    abstain: float = 0.0
    """Name no view where the chance is under this that, for volume, no other view in reach is better by 2 points of volume error,
    or, for coverage with --policy network, that it is the best; 0 for never."""

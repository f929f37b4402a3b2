"""The commands that make networks as dataclasses: the fields are the options, their docstrings the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train a network from a recipe, or go on with a run."""

    recipe: tyro.conf.Positional[str] = ""
    """Name of a shipped recipe (tiny, pc_nbv, pc_nbv_noview, compact, ...) or a TOML file (docs/training.md)."""
    data: Path | None = None
    """Folder of the data set (viewgain dataset build); default the recipe's own, built into the run's folder."""
    out: Path | None = None
    """Folder of the run; default runs/RECIPE."""
    resume: Annotated[Path | None, tyro.conf.arg(metavar="RUN")] = None
    """Go on with this run, from its newest whole checkpoint; the recipe is the run's own."""
    teacher: Path | None = None
    """Learn from this network too: an .onnx file or the folder of a run (docs/training.md). With --resume: where it is now."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where to compute; auto takes a GPU if there is one."""
    threads: int = 1
    """Threads of torch on the CPU; more pay for large networks only."""
    minutes: float | None = None
    """Stop cleanly after so long, earlier parts of the run included; the best weights are kept."""
    target: str | None = None
    """Which scores of the data are learned, for instance histogram:lines_published:soft+incidence; default the recipe's."""
    iterations: int | None = None
    """Steps at most; default the recipe's."""
    seed: int | None = None
    """Source of all randomness; default the recipe's."""


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write the best weights of a run as ONNX, with a model card."""

    run: tyro.conf.Positional[Path]
    """Folder of the run."""
    out: Path
    """File to write, .onnx."""
    source: str | None = None
    """What the training data is, for the card; default the name of its recipe."""
    licence: str | None = None
    """Licence of the training data, with --source."""
    metrics: Path | None = None
    """JSON list of further figures for the card: name, split, value, interval, floors, unit."""

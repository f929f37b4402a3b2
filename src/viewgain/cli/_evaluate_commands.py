"""The command that judges networks as dataclasses: the fields are the options, their docstrings the help."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from viewgain.cli._volume_commands import (
    EvaluateLabels,
    EvaluateLoop,
    EvaluateMap,
    EvaluateReal,
    EvaluateShapes,
    EvaluateTable2,
    EvaluateVolume,
)


@dataclass(frozen=True, kw_only=True)
class Judging:
    """What is judged, on what, and where the answer goes."""

    data: Path | None = None
    """Folder of a coverage data set (viewgain dataset build); its test parts are judged."""
    meshes: Path | None = None
    """Folder of meshes, category/name.ply (docs/meshes.md), that no network has seen."""
    fresh: int | None = None
    """Fresh procedural objects: so many in each of 8 categories that train and 8 that do not."""
    limit: int | None = None
    """Of --meshes: at most so many of each category, drawn with --seed."""
    models: tuple[str, ...] = ()
    """Networks: .onnx files or shipped names; default all shipped ones that fit."""
    floors_only: bool = False
    """No networks."""
    seed: int = 0
    """Of fresh objects, of what is drawn, and of the intervals."""
    workers: int = 1
    """Processes that look at objects; the figures are the same."""
    json: bool = False
    """One JSON object per table, one line each, and nothing else on stdout."""
    out: Path | None = None
    """Folder to write the tables into, as Markdown, JSON and (extra: report) a picture."""


@dataclass(frozen=True, kw_only=True)
class EvaluateTable1:
    """How often networks choose the best view, or one nearly as good, at the first step (the paper's Table 1)."""

    judging: Annotated[Judging, tyro.conf.arg(name="")] = field(default_factory=Judging)
    """What, on what, where to."""
    split: Literal["same_category", "other_category"] | None = None
    """New objects of seen categories, or unseen categories; default a table of each that there is."""
    frame: Literal["object", "camera"] | None = None
    """Frame of the points; default the object's (of --data its own), and beside it the other one if shipped networks want it."""
    target: str = "gain_published"
    """Which scores say what a view is worth: gain_published or gain_union."""


@dataclass(frozen=True, kw_only=True)
class EvaluateCoverage:
    """How much of objects policies cover, view after view (PC-NBV's protocol)."""

    judging: Annotated[Judging, tyro.conf.arg(name="")] = field(default_factory=Judging)
    """What, on what, where to."""
    rig: Literal["pcnbv33", "pcnbv16"] = "pcnbv33"
    """Candidate views."""
    policies: tuple[str, ...] = ()
    """Beside random, farthest and oracle, which are always there: uniform, proximity_count, ... (docs/volumetric.md)."""
    steps: int = 10
    """Views in all, the random first one included."""


@dataclass(frozen=True, kw_only=True)
class Evaluate:
    """Judge networks beside floors, with intervals."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[EvaluateTable1, tyro.conf.subcommand("table1")]
        | Annotated[EvaluateTable2, tyro.conf.subcommand("table2")]
        | Annotated[EvaluateLabels, tyro.conf.subcommand("labels")]
        | Annotated[EvaluateCoverage, tyro.conf.subcommand("coverage")]
        | Annotated[EvaluateVolume, tyro.conf.subcommand("volume")]
        | Annotated[EvaluateMap, tyro.conf.subcommand("map")]
        | Annotated[EvaluateReal, tyro.conf.subcommand("real")]
        | Annotated[EvaluateLoop, tyro.conf.subcommand("loop")]
        | Annotated[EvaluateShapes, tyro.conf.subcommand("shapes")]
    ]
    """Which table."""

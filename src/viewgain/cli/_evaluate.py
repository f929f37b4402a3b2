"""``viewgain evaluate``: networks beside floors, with intervals."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from viewgain.cli._evaluate_commands import Evaluate, EvaluateCoverage, EvaluateTable1
from viewgain.cli._evaluate_coverage import covered
from viewgain.cli._evaluate_labels import run_evaluate_labels
from viewgain.cli._evaluate_loop import run_evaluate_loop
from viewgain.cli._evaluate_map import run_evaluate_map
from viewgain.cli._evaluate_real import run_evaluate_real
from viewgain.cli._evaluate_shapes import run_evaluate_shapes
from viewgain.cli._evaluate_table2 import run_evaluate_table2
from viewgain.cli._evaluate_volume import run_evaluate_volume
from viewgain.cli._finish import finish
from viewgain.cli._judging import check_options, judged_data, named_scorers, note
from viewgain.cli._volume_commands import (
    EvaluateLabels,
    EvaluateLoop,
    EvaluateMap,
    EvaluateReal,
    EvaluateShapes,
    EvaluateTable2,
    EvaluateVolume,
)
from viewgain.datasets import Dataset, Frame, rig_of
from viewgain.errors import ConfigError
from viewgain.evaluation import (
    SEEN,
    Judgement,
    Part,
    Table1,
    coverage_to_markdown,
    fresh_parts,
    mesh_parts,
    of_frame,
    shipped_scorers,
    table1,
    to_markdown,
    trained_parts,
)
from viewgain.gain import PAPER
from viewgain.inference import Scorer
from viewgain.report import write_coverage_picture, write_table1_picture


def run_evaluate(command: Evaluate) -> int:
    """Print the tables.

    Raises:
        StorageError: If they, or what is kept of boxes and folds, cannot be written.
    """
    return _RUNS[type(command.action)](command.action)


def _table1(command: EvaluateTable1) -> int:
    options = command.judging
    check_options(options)
    if options.meshes is not None and command.split is not None:
        raise ConfigError("evaluate: got --split with --meshes, which are one part; leave it out")
    named = named_scorers(options.models)
    if options.data is None:
        _refuse(named, command.frame or "object", PAPER.rig)  # before objects are made, which takes its time
    with judged_data(options) as data:
        if options.data is not None:
            parts = trained_parts(data, command.split)
        else:
            parts = mesh_parts(data) if options.meshes is not None else fresh_parts(data, command.split)
        framed = _by_frame(command, data, named)
        tables = [table for frame, each in framed for table in _judged(command, data, parts, frame, each)]
    finish(
        "table1",
        as_json="".join(json.dumps(table.to_dict(), allow_nan=False) + "\n" for table in tables),
        as_markdown="\n".join(map(to_markdown, tables)),
        prints_json=options.json,
        out=options.out,
        draw=lambda path: write_table1_picture(tables, path),
    )
    return 0


def _judged(
    command: EvaluateTable1, data: Dataset, parts: Sequence[Part], frame: Frame, scorers: dict[str, Scorer]
) -> Iterator[Table1]:
    """Yield the table of each part; unseen categories are held against the seen ones."""
    seen: Judgement | None = None
    for part in parts:
        found = table1(data, scorers, part, target=command.target, frame=frame, seed=command.judging.seed, seen=seen)
        if part.name == SEEN:
            seen = found
        yield found.table


def _refuse(scorers: dict[str, Scorer], frame: Frame, rig: str) -> None:
    """Raise ConfigError if a network is of another frame or rig."""
    for scorer in scorers.values():
        reason = scorer.refusal(frame=frame, rig=rig)
        if reason:
            raise ConfigError(f"evaluate: {reason}")


def _coverage(command: EvaluateCoverage) -> int:
    tables = covered(command)
    finish(
        "coverage",
        as_json="".join(json.dumps(table.to_dict(), allow_nan=False) + "\n" for table in tables),
        as_markdown="\n".join(map(coverage_to_markdown, tables)),
        prints_json=command.judging.json,
        out=command.judging.out,
        draw=lambda path: write_coverage_picture(tables, path),
    )
    return 0


def _by_frame(command: EvaluateTable1, data: Dataset, named: dict[str, Scorer]) -> Sequence[tuple[Frame, dict[str, Scorer]]]:
    """Return the frames to judge in, each with its networks."""
    options, own = command.judging, command.frame or data.manifest.frame
    if options.models or options.floors_only:
        return [(own, named)]
    shipped = shipped_scorers(rig_of(data.manifest))
    frames: tuple[Frame, ...] = ("object", "camera")
    chosen = [own] if command.frame else sorted(frames, key=lambda frame: frame != own)
    found = [(frame, of_frame(shipped, frame)) for frame in chosen]
    if not any(scorers for _, scorers in found):
        note(f"no shipped network fits rig {rig_of(data.manifest)} in the {' or '.join(chosen)} frame: floors alone")
    return [(frame, scorers) for frame, scorers in found if scorers or frame == own]


_RUNS: Mapping[type, Callable[[Any], int]] = {
    EvaluateTable1: _table1,
    EvaluateCoverage: _coverage,
    EvaluateTable2: run_evaluate_table2,
    EvaluateLabels: run_evaluate_labels,
    EvaluateVolume: run_evaluate_volume,
    EvaluateLoop: run_evaluate_loop,
    EvaluateShapes: run_evaluate_shapes,
    EvaluateMap: run_evaluate_map,
    EvaluateReal: run_evaluate_real,
}
"""What answers each question."""

"""``viewgain evaluate table2``: the paper's Table 2, of networks that are given and of some trained for each choice of boxes."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.cli._exit import NOT_WRITTEN, print_error
from viewgain.cli._volume_commands import EvaluateTable2
from viewgain.datasets import Dataset, make_folder, write_whole
from viewgain.errors import ConfigError, StorageError
from viewgain.evaluation import leave_out, table2, table2_markdown
from viewgain.inference import Scorer


def run_evaluate_table2(command: EvaluateTable2) -> int:
    """Print the table; exit code 4 if the folder cannot be written."""
    if command.captures < 1 or command.folds < 0 or (command.folds and command.out is None):
        raise ConfigError("evaluate table2: wanted captures of 1 or more, folds of 0 or more, and with folds a folder: add --out")
    data = Dataset(command.data)
    names = [Path(model).stem if model.endswith(".onnx") else model for model in command.models]
    if len(set(names)) < len(names):
        raise ConfigError(f"evaluate table2: got the networks {', '.join(names)}, wanted different names; rename a file")
    scorers = {name: Scorer.load(model) for name, model in zip(names, command.models, strict=True)}
    table = table2(data, scorers, target=command.target, captures=command.captures, seed=command.seed)
    texts, lines = [table2_markdown(table)], [json.dumps(table.to_dict(), allow_nan=False)]
    try:
        if command.folds and command.out is not None:
            found = _folds(command, data, command.out)
            texts.append(_folds_markdown(found, command))
            lines.append(json.dumps({"folds": found}, allow_nan=False))
        as_json, as_markdown = "\n".join(lines) + "\n", "\n".join(texts)
        print(as_json if command.json else as_markdown, end="")
        if command.out is not None:
            make_folder(command.out)
            write_whole(command.out / "table2.json", as_json.encode())
            write_whole(command.out / "table2.md", as_markdown.encode())
    except StorageError as error:
        print_error(error)
        return NOT_WRITTEN
    return 0


def _folds(command: EvaluateTable2, data: Dataset, out: Path) -> list[dict[str, Any]]:
    """Return, for every choice of held-out boxes, what a network trained without them gets; what is there already is kept."""
    choices = leave_out(np.unique(data.column("object")).tolist(), command.leave, most=command.folds, seed=command.seed)
    found = []
    for number, held in enumerate(choices):
        folder = out / "folds" / "-".join(map(str, held))
        make_folder(folder)
        result = folder / "table2.json"
        if not result.exists():
            print(f"fold {number + 1} of {len(choices)}: without boxes {', '.join(map(str, held))}", file=sys.stderr)
            write_whole(result, (json.dumps(_fold(command, data, held, folder), allow_nan=False) + "\n").encode())
        found.append(json.loads(result.read_text(encoding="utf-8")))
    return found


def _fold(command: EvaluateTable2, data: Dataset, held: tuple[int, ...], folder: Path) -> dict[str, Any]:
    from viewgain.training import Means, export_run, resume, start, training_recipe

    recipe = training_recipe(command.recipe)
    divisions = tuple(name for name in recipe.data.divisions if name != "other_box")
    own = replace(recipe, data=replace(recipe.data, without=held, divisions=divisions, target=command.target))
    run, means = folder / "run", Means(minutes=command.minutes)
    if (run / "run.json").exists():
        resume(run, data=data.folder, means=means)
    else:
        start(own, run, data=data.folder, means=means)
    export_run(run, folder / "network.onnx")
    scorers = {"network": Scorer.load(folder / "network.onnx")}
    table = table2(data, scorers, target=command.target, captures=command.captures, other=held, seed=command.seed)
    return table.to_dict()


def _folds_markdown(found: list[dict[str, Any]], command: EvaluateTable2) -> str:
    """Return means over the folds, and the spread between them."""
    lines = [
        f"## Table 2 over {len(found)} choices of {command.leave} held-out boxes, {command.recipe}, {command.minutes:g} min each",
        "",
        "Mean over the choices, and the 2.5 and 97.5 % quantiles of them.",
        "",
        "| | same boxes, % | other boxes, % |",
        "| --- | --- | --- |",
    ]
    for place, row in enumerate(found[0]["rows"]):
        cells = [_spread([each["rows"][place][part]["mean"][0] for each in found]) for part in ("same", "other")]
        lines.append(f"| {row['name']} | {cells[0]} | {cells[1]} |")
    return "\n".join(lines) + "\n"


def _spread(values: list[float]) -> str:
    low, high = np.quantile(values, [0.025, 0.975])
    return f"{100 * np.mean(values):.2f} ({100 * low:.1f} to {100 * high:.1f})"

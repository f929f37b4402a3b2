"""The folds of ``viewgain evaluate table2``: a network trained for each choice of held-out boxes, kept and gone on with."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.cli._volume_commands import EvaluateTable2
from viewgain.datasets import Dataset, make_folder, write_whole
from viewgain.errors import StorageError
from viewgain.evaluation import boxes_of, claim, damaged, kept_text, leave_out, markdown_table, table2
from viewgain.inference import Scorer
from viewgain.training import Means, TrainingRecipe, export_run, recipe_to_table, resume, start, training_recipe


def folds(command: EvaluateTable2, data: Dataset, out: Path) -> list[dict[str, Any]]:
    """Return, for every choice of held-out boxes, what a network trained without them gets; what is there already is kept.

    Args:
        command: The command line.
        data: The scans.
        out: Folder of the folds, each under the numbers of its held-out boxes; made if it is missing.

    Raises:
        ConfigError: If so many boxes cannot be held out, or the recipe makes no sense.
        DataError: If the folder holds results of other settings, or a result in it is damaged.
        StorageError: If it cannot be written.
    """
    boxes = boxes_of(data)
    chosen = leave_out(range(len(boxes)), command.leave, most=command.folds, seed=command.seed)
    choices = [tuple(sorted(number for box in choice for number in boxes[box])) for choice in chosen]
    recipe = training_recipe(command.recipe)
    claim(out, _question(command, data, recipe))
    found = []
    for number, held in enumerate(choices):
        folder = out / "-".join(map(str, held))
        result = folder / "table2.json"
        text = kept_text(result)
        if text is None:
            print(f"fold {number + 1} of {len(choices)}: without boxes {', '.join(map(str, held))}", file=sys.stderr)
            make_folder(folder)
            text = json.dumps(_fold(command, data, recipe, held, folder), allow_nan=False) + "\n"
            write_whole(result, text.encode())
        found.append(_read(text, result, held))
    return found


def _question(command: EvaluateTable2, data: Dataset, recipe: TrainingRecipe) -> dict[str, Any]:
    """Return all that a fold's result depends on but for its boxes, so that more folds or other choices can be added."""
    return {
        "data": data.manifest.plan,
        "recipe": recipe_to_table(recipe),
        "minutes": command.minutes,
        "target": command.target,
        "captures": command.captures,
        "seed": command.seed,
    }


def _read(text: str, file: Path, held: tuple[int, ...]) -> dict[str, Any]:
    try:
        table: dict[str, Any] = json.loads(text)
        is_whole = tuple(table["other_boxes"]) == held and len(table["rows"]) > 0
    except (ValueError, TypeError, KeyError) as error:
        raise damaged(file) from error
    if not is_whole:
        raise damaged(file)
    return table


def _fold(command: EvaluateTable2, data: Dataset, recipe: TrainingRecipe, held: tuple[int, ...], folder: Path) -> dict[str, Any]:
    divisions = tuple(name for name in recipe.data.divisions if name != "other_box")
    own = replace(recipe, data=replace(recipe.data, without=held, divisions=divisions, target=command.target))
    run, network, means = folder / "run", folder / "network.onnx", Means(minutes=command.minutes)
    if (run / "run.json").exists():
        resume(run, data=data.folder, means=means)
    else:
        start(own, run, data=data.folder, means=means)
    try:
        export_run(run, network)
    except OSError as error:
        raise StorageError(f"{network}: cannot be written ({error.strerror or error}); check the folder") from error
    scorers = {"network": Scorer.load(network)}
    table = table2(data, scorers, target=command.target, captures=command.captures, other=held, seed=command.seed)
    return table.to_dict()


def folds_markdown(found: list[dict[str, Any]], command: EvaluateTable2) -> str:
    """Return means over the folds, and the spread between them."""
    rows = [
        (row["name"], *(_spread([each["rows"][place][part]["mean"][0] for each in found]) for part in ("same", "other")))
        for place, row in enumerate(found[0]["rows"])
    ]
    lines = [
        f"## Table 2 over {len(found)} choices of {command.leave} held-out boxes, {command.recipe}, {command.minutes:g} min each",
        "",
        "Mean over the choices, and the 2.5 and 97.5 % quantiles of them.",
        "",
        *markdown_table(("", "same boxes, %", "other boxes, %"), rows),
    ]
    return "\n".join(lines) + "\n"


def _spread(values: list[float]) -> str:
    low, high = np.quantile(values, [0.025, 0.975])
    return f"{100 * np.mean(values):.2f} ({100 * low:.1f} to {100 * high:.1f})"

"""``viewgain evaluate table2``: the paper's Table 2, of networks that are given and of some trained for each choice of boxes."""

import json
from pathlib import Path

from viewgain.cli._finish import finish
from viewgain.cli._volume_commands import EvaluateTable2
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError
from viewgain.evaluation import table2, table2_markdown
from viewgain.inference import Scorer


def run_evaluate_table2(command: EvaluateTable2) -> int:
    """Print the table."""
    if command.captures < 1 or command.folds < 0 or (command.folds and command.out is None):
        raise ConfigError("evaluate table2: wanted captures of 1 or more, folds of 0 or more, and with folds a folder: add --out")
    data = Dataset(command.data)
    names = [Path(model).stem if model.endswith(".onnx") else model for model in command.models]
    if len(set(names)) < len(names):
        raise ConfigError(f"evaluate table2: got the networks {', '.join(names)}, wanted different names; rename a file")
    scorers = {name: Scorer.load(model) for name, model in zip(names, command.models, strict=True)}
    table = table2(data, scorers, target=command.target, captures=command.captures, seed=command.seed)
    texts, lines = [table2_markdown(table)], [json.dumps(table.to_dict(), allow_nan=False)]
    if command.folds and command.out is not None:
        from viewgain.cli._table2_folds import folds, folds_markdown  # the floors alone need no torch

        found = folds(command, data, command.out / "folds")
        texts.append(folds_markdown(found, command))
        lines.append(json.dumps({"folds": found}, allow_nan=False))
    finish(
        "table2",
        as_json="\n".join(lines) + "\n",
        as_markdown="\n".join(texts),
        prints_json=command.json,
        out=command.out,
    )
    return 0

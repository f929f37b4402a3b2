"""``viewgain evaluate``: Table 1 of networks, beside floors and with intervals; the others by modules of their own."""

import json
from collections.abc import Sequence
from pathlib import Path

from viewgain.cli._exit import NOT_WRITTEN, print_error
from viewgain.cli._training_commands import Evaluate, EvaluateTable1
from viewgain.cli._volume_commands import EvaluateTable2, EvaluateVolume
from viewgain.datasets import Dataset, make_folder, write_whole
from viewgain.errors import ConfigError, DataError, StorageError
from viewgain.evaluation import RESERVED, SPLITS, judged_rows, table1, to_markdown
from viewgain.inference import Scorer


def run_evaluate(command: Evaluate) -> int:
    """Run one of the evaluations."""
    if isinstance(command.what, EvaluateVolume):
        from viewgain.cli._evaluate_volume import run_evaluate_volume

        return run_evaluate_volume(command.what)
    if isinstance(command.what, EvaluateTable2):
        from viewgain.cli._evaluate_table2 import run_evaluate_table2

        return run_evaluate_table2(command.what)
    return _run_table1(command.what)


def _run_table1(command: EvaluateTable1) -> int:
    """Print the tables; exit code 4 if the folder cannot be written."""
    data = Dataset(command.data)
    scorers = _scorers(command.models)
    splits = (command.split,) if command.split is not None else _judgeable(data)
    tables = [table1(data, scorers, split=split, target=command.target, seed=command.seed) for split in splits]
    as_json = "".join(json.dumps(table.to_dict(), allow_nan=False) + "\n" for table in tables)
    as_markdown = "\n".join(map(to_markdown, tables))
    print(as_json if command.json else as_markdown, end="")
    try:
        if command.out is not None:
            make_folder(command.out)
            write_whole(command.out / "table1.json", as_json.encode())
            write_whole(command.out / "table1.md", as_markdown.encode())
    except StorageError as error:
        print_error(error)
        return NOT_WRITTEN
    return 0


def _scorers(models: Sequence[str]) -> dict[str, Scorer]:
    """Return the networks by the names of their files."""
    names = [Path(model).stem if model.endswith(".onnx") else model for model in models]
    if len({*names, *RESERVED}) < len(names) + len(RESERVED):
        raise ConfigError(
            f"evaluate: got the networks {', '.join(names)}, wanted different names, and none of a floor; rename a file"
        )
    return {name: Scorer.load(model, threads=1) for name, model in zip(names, models, strict=True)}


def _judgeable(data: Dataset) -> list[str]:
    """Return the divisions that have something to judge."""
    there = [split for split in SPLITS if split in data.manifest.tables.splits and len(judged_rows(data, split))]
    if not there:
        raise DataError(
            f"{data.folder}: got no sample in a test part of {' or '.join(SPLITS)}; build coverage data with more objects"
        )
    return there

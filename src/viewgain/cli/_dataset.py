"""``viewgain dataset``: build training data from a recipe, list recipes, look at a data set, verify it, export it."""

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

from rich.table import Table

from viewgain.cli._commands import Dataset, DatasetBuild, DatasetExport, DatasetInfo, DatasetRecipes, DatasetVerify
from viewgain.cli._exit import DAMAGED, NOT_WRITTEN, print_error
from viewgain.cli._progress import bar
from viewgain.cli._text import to_stdout
from viewgain.datasets import (
    RECIPES,
    Manifest,
    add_volume_errors,
    build,
    check_estimators,
    engine,
    estimators_of,
    export_hf,
    plan_of,
    read_manifest,
    recipe,
    verify,
)
from viewgain.errors import ConfigError, StorageError

_MOST_REASONS = 5
"""Reasons for what was skipped that are printed; all of them are in the file."""


def run_dataset(command: Dataset) -> int:
    """Run one of the actions; exit code 4 if the folder cannot be written, 3 if verify finds damage."""
    action = command.action
    try:
        if isinstance(action, DatasetBuild):
            return _build(action)
        if isinstance(action, DatasetRecipes):
            return _recipes()
        if isinstance(action, DatasetInfo):
            return _info(action)
        if isinstance(action, DatasetVerify):
            return _verify(action)
        return _export(action)
    except StorageError as error:
        print_error(error)
        return NOT_WRITTEN


def _build(command: DatasetBuild) -> int:
    chosen = recipe(command.recipe)
    if command.seed is not None:
        chosen = replace(chosen, seed=command.seed)
    if command.ray_address is not None and command.engine != "ray":
        raise ConfigError("got --ray-address without --engine ray; add it")
    plan = plan_of(chosen, meshes=_absolute(command.meshes), recordings=_absolute(command.recordings))
    check_estimators(plan, command.errors)
    runner = engine(command.engine, workers=command.workers, address=command.ray_address)
    with bar("units") as watch:
        manifest = build(plan, command.out, engine=runner, resume=command.resume, watch=watch)
    if command.errors:
        with bar("units, volume errors") as watch:
            add_volume_errors(plan, command.out, command.errors, engine=runner, watch=watch)
    print(f"{command.out}: {_in_words(manifest)}")
    _say_skipped(manifest, command.out)
    return 0


def _recipes() -> int:
    table = Table(title="viewgain dataset build RECIPE --out DIR", title_justify="left", title_style="bold")
    for column in ("recipe", "makes", "takes"):
        table.add_column(column)
    for name in RECIPES:
        each = recipe(name)
        table.add_row(name, each.makes, each.takes)
    to_stdout(table)
    return 0


def _info(command: DatasetInfo) -> int:
    manifest = read_manifest(command.folder)
    errors = {name: f"{count} of {len(manifest.shards)} shards" for name, count in estimators_of(command.folder).items()}
    facts = {
        "recipe": manifest.recipe["name"],
        "seed": manifest.recipe["seed"],
        "samples": manifest.samples,
        "points": manifest.points,
        "bytes": manifest.bytes,
        "shards": len(manifest.shards),
        "objects": len(manifest.objects),
        "categories": len(manifest.tables.categories),
        "cameras": list(manifest.tables.cameras),
        "frame": manifest.frame,
        "order": manifest.order,
        "targets": list(manifest.targets),
        "volume_errors": errors,
        "divisions": list(manifest.tables.splits),
        "skipped": len(manifest.skipped),
        "viewgain": manifest.viewgain,
    }
    if command.json:
        print(json.dumps(facts))
        return 0
    table = Table(title=str(command.folder), title_justify="left", title_style="bold", show_header=False)
    for name, value in facts.items():
        table.add_row(name, f"{value:,}" if isinstance(value, int) else _plain(value))
    to_stdout(table)
    return 0


def _verify(command: DatasetVerify) -> int:
    problems = verify(command.folder)
    for problem in problems:
        print(problem)
    if problems:
        print(f"{len(problems)} files are not as they were written; run the build again with --resume")
        return DAMAGED
    manifest = read_manifest(command.folder)
    print(f"{command.folder}: all {len(manifest.shards)} shards are as they were written, {manifest.bytes:,} bytes")
    return 0


def _export(command: DatasetExport) -> int:
    kind = export_hf(command.folder, command.out)
    print(f"{command.out}: written as {kind}, with a README.md; look at its licence before you publish it")
    return 0


def _plain(value: object) -> str:
    """Return a list or a table in words, anything else as it is."""
    if isinstance(value, dict):
        return ", ".join(f"{name}: {each}" for name, each in value.items()) or "none"
    return (", ".join(map(str, value)) or "none") if isinstance(value, list) else str(value)


def _absolute(folder: Path | None) -> Path | None:
    """Return a folder as every process knows it."""
    return None if folder is None else folder.absolute()


def _in_words(manifest: Manifest) -> str:
    size = manifest.bytes / 1e6
    return f"{manifest.samples:,} samples of {len(manifest.objects):,} objects in {len(manifest.shards)} shards, {size:,.1f} MB"


def _say_skipped(manifest: Manifest, folder: Path) -> None:
    """Print the commonest reasons why something was skipped."""
    if not manifest.skipped:
        return
    print(f"{len(manifest.skipped)} skipped, each with its reason in {folder / 'skipped.jsonl'}:")
    for reason, count in Counter(each.reason for each in manifest.skipped).most_common(_MOST_REASONS):
        print(f"  {count} x {reason}")

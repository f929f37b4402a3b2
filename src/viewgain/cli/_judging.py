"""What the commands that judge networks share: objects to judge on, and networks by name."""

import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from viewgain.cli._evaluate_commands import Judging
from viewgain.cli._progress import bar
from viewgain.datasets import Dataset, LocalEngine, Plan, Skipped, build
from viewgain.errors import ConfigError
from viewgain.evaluation import RESERVED, fresh_plan, mesh_plan
from viewgain.inference import Scorer

_MOST_NAMED = 20
"""Skipped objects that are named; all of them are in the JSON."""


def note(text: str) -> None:
    """Say something beside the answer, on stderr."""
    print(f"viewgain: {text}", file=sys.stderr)


@contextmanager
def judged_data(options: Judging) -> Iterator[Dataset]:
    """Give the data set to judge on: a finished one, or one of fresh objects or given meshes in a folder that goes away.

    Raises:
        ConfigError: If there is no object to make.
        DataError: If there is no data set, or nothing of the objects could be made.
        MeshError: If there is no mesh.
        StorageError: If the temporary folder is full.
    """
    if options.data is not None:
        yield Dataset(options.data)
        return
    with tempfile.TemporaryDirectory(prefix="viewgain-") as folder:
        plan = planned(options)
        with bar("objects") as watch:
            manifest = build(plan, Path(folder), engine=LocalEngine(options.workers), watch=watch)
        say_skipped(manifest.skipped)
        yield Dataset(folder)


def check_options(options: Judging, *, meshes_of_data: bool = False) -> None:
    """Make sure that exactly one source of objects is named, and that the other options go with it.

    Args:
        options: The options.
        meshes_of_data: Whether a data set may come with the meshes that it was built from.

    Raises:
        ConfigError: If not, or a limit is without meshes, or networks are named and refused at once.
    """
    given = [f"--{name}" for name in ("data", "meshes", "fresh") if getattr(options, name) is not None]
    if len(given) != 1 and not (meshes_of_data and given == ["--data", "--meshes"]):
        raise ConfigError(
            f"evaluate: got {' and '.join(given) or 'no objects'}, wanted one of --data DIR, --meshes FOLDER, --fresh N"
        )
    if options.limit is not None and given != ["--meshes"]:
        raise ConfigError(f"evaluate: got --limit with {' and '.join(given)}; it goes with --meshes alone")
    if options.floors_only and options.models:
        raise ConfigError("evaluate: got --models and --floors-only, wanted one of them")
    if options.seed < 0:
        raise ConfigError(f"evaluate: got --seed {options.seed}, wanted 0 or more")


def planned(options: Judging) -> Plan:
    """Return the plan of fresh objects or given meshes."""
    if options.meshes is not None:
        return mesh_plan(options.meshes, limit=options.limit, seed=options.seed)
    return fresh_plan(options.fresh or 0, seed=options.seed)


def say_skipped(skipped: Sequence[Skipped]) -> None:
    """Name what could not be made, with the reasons."""
    for each in skipped[:_MOST_NAMED]:
        note(f"skipped {each.name}: {each.reason}")
    if len(skipped) > _MOST_NAMED:
        note(f"skipped {len(skipped) - _MOST_NAMED} more")


def named_scorers(models: Sequence[str], *, reserved: Sequence[str] = RESERVED) -> dict[str, Scorer]:
    """Return networks by the names of their files.

    Raises:
        ConfigError: If two have the same name, or one that of a floor.
        ModelError: If there is no such network, or it is damaged.
    """
    names = [Path(model).stem if model.endswith(".onnx") else model for model in models]
    if len({*names, *reserved}) < len(names) + len(reserved):
        raise ConfigError(
            f"evaluate: got the networks {', '.join(names)}, wanted different names, and none of a floor; rename a file"
        )
    return {name: Scorer.load(model, threads=1) for name, model in zip(names, models, strict=True)}

"""Coverage episodes on a run's own validation objects, beside the shipped networks: by this, choices of training are made."""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from viewgain.datasets import Dataset, LocalEngine
from viewgain.evaluation import (
    Played,
    PlayTask,
    check_policies,
    coverage_table,
    coverage_to_markdown,
    data_plan,
    play,
    shipped_scorers,
)
from viewgain.gain import COVERAGE_PROTOCOLS
from viewgain.inference import find_model
from viewgain.training import RunRecord, export_run, load_trained, shown_and_aside

STEPS = 10


def run(options: argparse.Namespace) -> None:
    """Print one table: the runs that ``--runs`` names play on the validation objects of the first."""
    if not options.runs:
        print("run-episodes: name training runs with --runs RUN ...\n")
        return
    record = load_trained(options.runs[0]).record
    with TemporaryDirectory() as folder:
        networks = [(path.name, Path(folder) / f"{path.name}.onnx") for path in options.runs]
        for path, (_, file) in zip(options.runs, networks, strict=True):
            export_run(path, file)
        networks += [(f"shipped {name}", find_model(name)) for name in shipped_scorers(str(record.facts["rig"]))]
        played = _played(record, Path(options.data[0] if options.data else record.data), tuple(networks), options.workers)
    title = f"validation objects of the run {options.runs[0].name}"
    protocol = _protocol(record)
    print(coverage_to_markdown(coverage_table(played, data=str(record.data), split="validation", title=title, protocol=protocol)))


def _played(record: RunRecord, folder: Path, networks: tuple[tuple[str, Path], ...], workers: int) -> list[Played]:
    data = Dataset(folder)
    examples, aside = shown_and_aside(record.recipe, data)
    plan, objects = data_plan(data.manifest), set(np.unique(examples.objects[aside]).tolist())
    protocol, policies, seed = _protocol(record), check_policies(()), plan.recipe.seed
    tasks = [
        PlayTask(unit=unit, mesh_seed=seed, protocol=protocol, policies=policies, networks=networks, steps=STEPS, seed=0)
        for unit in plan.units
        if unit.object in objects
    ]
    return [result for _, result in LocalEngine(workers).run(play, tasks) if isinstance(result, Played)]


def _protocol(record: RunRecord) -> str:
    return next(name for name, each in COVERAGE_PROTOCOLS.items() if each.rig == record.facts["rig"])

"""How fast training data is made and read: models and box scans into shards, volume errors, random reads, beside slow twins.

Everything on one thread, in processor time, which a shared machine changes little; the reads come from files that are in memory.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._tables import markdown
from viewgain.datasets import Dataset, build, plan_of, recipe
from viewgain.datasets._build import task_of
from viewgain.datasets._volume_errors import ErrorTask, shard_errors
from viewgain.datasets._work import make_shard
from viewgain.gain import ESTIMATORS

MODELS = 12
"""Meshes that are timed of each recipe, spread over its categories."""
SCANS = 88
"""Box scans that are timed, and half as many for each estimator; spread over boxes and positions."""
BOXES = 22
"""Units of work that they are taken from."""
READS = 20_000
PAPER_SCANS = 44_000


class Here:
    """An engine without processes."""

    def run(self, work: Callable[[Any], Any], tasks: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        """Run the tasks one by one."""
        for task in tasks:
            yield task, work(task)


def run(options: argparse.Namespace) -> None:
    """Print the tables."""
    del options
    print("## Data sets, end to end\n")
    rows = [*_models(), *_scans(), *_errors()]
    print(markdown(("what", "processor time", "rate of one core", "goal"), rows))
    print()
    with tempfile.TemporaryDirectory() as folder:
        print(markdown(("random reads", "samples/s", "goal"), _reads(Path(folder))))
    print()


def _models() -> Iterator[tuple[str, str, str, str]]:
    for name, what in (
        ("coverage_pcnbv", "33 views, 10 steps"),
        ("coverage_paper", "16 views, 16 starts"),
        ("meshes_random", ""),
    ):
        plan = plan_of(recipe(name))
        task = task_of(plan, 0)
        make_shard(replace(task, units=plan.units[:1]))  # compiles
        chosen = plan.units[:: len(plan.units) // MODELS][:MODELS]
        seconds = _processor(lambda task=task, chosen=chosen: make_shard(replace(task, units=chosen))) / len(chosen)
        goal = "1 model/s" if name == "coverage_pcnbv" else ""
        yield f"{name}: mesh to shard{', ' if what else ''}{what}", f"{seconds:.2f} s/model", f"{1 / seconds:.2f} models/s", goal


def _scans() -> Iterator[tuple[str, str, str, str]]:
    plan = plan_of(recipe("boxes_paper"))
    make_shard(replace(task_of(plan, 0), units=_few(plan, 2, 2)))
    units = _few(plan, BOXES, SCANS // BOXES)
    seconds = _processor(lambda: make_shard(replace(task_of(plan, 0), units=units))) / sum(len(unit.source[1]) for unit in units)
    whole = PAPER_SCANS * seconds / 2 / 60
    rate = f"{1 / seconds:.0f} scans/s"
    yield f"boxes_paper: scan to shard (44,000 on two cores: {whole:.1f} min)", f"{1e3 * seconds:.1f} ms/scan", rate, "6 min"


def _errors() -> Iterator[tuple[str, str, str, str]]:
    plan = plan_of(recipe("boxes_paper"))
    units = _few(plan, BOXES, SCANS // BOXES // 2)
    for name in ESTIMATORS:
        task = ErrorTask(shard=replace(task_of(plan, 0), units=units), estimators=(name,))
        seconds = _processor(lambda task=task: shard_errors(task)) / sum(len(unit.source[1]) for unit in units)
        whole = PAPER_SCANS * seconds / 2 / 60
        what = f"boxes_paper: scan and volume error, {name} (44,000 on two cores: {whole:.0f} min)"
        yield what, f"{1e3 * seconds:.0f} ms/scan", f"{1 / seconds:.1f} scans/s", "40 min"


def _few(plan: Any, units: int, captures: int) -> tuple[Any, ...]:
    """Return some units of boxes, spread over boxes and positions, with only their first scans."""
    chosen = plan.units[:: max(1, len(plan.units) // units)][:units]
    return tuple(replace(unit, source=(unit.source[0], unit.source[1][:captures])) for unit in chosen)


def _reads(folder: Path) -> list[tuple[str, str, str]]:
    small = recipe("boxes_paper")
    rules = replace(small.content, captures=12, captures_per_unit=12, train_captures=9)  # type: ignore[type-var]
    build(plan_of(replace(small, content=rules)), folder, engine=Here())  # type: ignore[arg-type]
    data = Dataset(folder)
    places = np.random.default_rng(0).integers(len(data), size=READS).tolist()
    _read(data, places)  # opens the shards
    fast = _processor(lambda: _read(data, places))
    np.savez(folder / "one.npz", **{name: np.asarray(getattr(data[0], name)) for name in ("points", "candidates", "state")})
    slow = _processor(lambda: [dict(np.load(folder / "one.npz")) for _ in range(READS // 20)]) * 20
    points = f"{data.manifest.points / len(data):,.0f} points a sample"
    return [
        (f"memory-mapped shards, whole samples, {points}", f"{READS / fast:,.0f}", "20,000"),
        ("one .npz file per sample, three arrays, always the same file", f"{READS / slow:,.0f}", ""),
    ]


def _read(data: Dataset, places: Sequence[int]) -> None:
    for place in places:
        data[place]


def _processor(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start

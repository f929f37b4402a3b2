"""``viewgain evaluate volume``: planners on fresh boxes, beside floors, ceiling and oracle."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from viewgain.cli._exit import NOT_WRITTEN, print_error
from viewgain.cli._volume_commands import EvaluateVolume
from viewgain.datasets import write_whole
from viewgain.errors import ConfigError, StorageError
from viewgain.evaluation import VolumeSettings, check_volume_policies, run_boxes, volume_markdown, volume_table


def run_evaluate_volume(command: EvaluateVolume) -> int:
    """Print the table; exit code 4 if the folder cannot be written."""
    if command.boxes < 2:
        raise ConfigError(f"evaluate volume: got {command.boxes} boxes, wanted 2 or more")
    check_volume_policies(command.policies)
    settings = VolumeSettings(
        seed=command.seed,
        rig=command.rig,
        camera=command.camera,
        estimator=command.estimator,
        captures=command.captures,
        fused=command.fused,
        side=command.side,
        distance=command.distance,
        elevation_deg=command.elevation,
    )
    try:
        with _bar() as watch:
            runs = run_boxes(settings, command.boxes, command.policies, workers=command.workers, folder=command.out, watch=watch)
        table = volume_table(settings, runs, command.policies)
        as_json, as_markdown = json.dumps(table.to_dict(), allow_nan=False) + "\n", volume_markdown(table)
        print(as_json if command.json else as_markdown, end="")
        if command.out is not None:
            write_whole(command.out / "volume.json", as_json.encode())
            write_whole(command.out / "volume.md", as_markdown.encode())
    except StorageError as error:
        print_error(error)
        return NOT_WRITTEN
    return 0


@contextmanager
def _bar() -> Iterator[Callable[[int, int], None]]:
    """Give a watcher that draws a bar on stderr."""
    columns = (
        TextColumn("boxes"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("boxes", total=None)

        def watch(done: int, total: int) -> None:
            bar.update(task, total=total, completed=done)

        yield watch

"""``viewgain evaluate volume``: planners on fresh boxes, beside floors, ceiling and oracle."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from viewgain.cli._finish import finish
from viewgain.cli._volume_commands import EvaluateVolume
from viewgain.errors import ConfigError
from viewgain.evaluation import VolumeSettings, check_volume_policies, run_boxes, volume_markdown, volume_table


def run_evaluate_volume(command: EvaluateVolume) -> int:
    """Print the table."""
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
    with boxes_bar() as watch:
        runs = run_boxes(settings, command.boxes, command.policies, workers=command.workers, folder=command.out, watch=watch)
    table = volume_table(settings, runs, command.policies)
    finish(
        "volume",
        as_json=json.dumps(table.to_dict(), allow_nan=False) + "\n",
        as_markdown=volume_markdown(table),
        prints_json=command.json,
        out=command.out,
    )
    return 0


@contextmanager
def boxes_bar() -> Iterator[Callable[[int, int], None]]:
    """Give a watcher that draws a bar on stderr."""
    columns = (
        TextColumn("boxes"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    bar = Progress(*columns, console=Console(stderr=True))
    task = bar.add_task("boxes", total=None)

    def watch(done: int, total: int) -> None:
        bar.start()  # only now, so that what is refused before the first box is one line
        bar.update(task, total=total, completed=done)

    try:
        yield watch
    finally:
        if bar.live.is_started:
            bar.stop()

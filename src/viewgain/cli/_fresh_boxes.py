"""Fresh boxes as the commands name them: the settings they make, how many are enough, and the bar while they are worked out."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from viewgain.cli._volume_commands import EvaluateLoop, EvaluateMap, EvaluateVolume
from viewgain.errors import ConfigError
from viewgain.evaluation import VolumeSettings


def boxes_alone(command: EvaluateVolume | EvaluateMap) -> VolumeSettings:
    """Return the question of a command that judges positions by an estimator; raises ConfigError as VolumeSettings does."""
    return VolumeSettings(
        seed=command.seed,
        rig=command.rig,
        camera=command.camera,
        estimator=command.estimator,
        captures=command.captures,
        fused=command.fused,
        side=command.side,
        distance=command.distance,
        elevation_deg=command.elevation,
        off_centre=command.off_centre,
    )


def require_two(command: EvaluateVolume | EvaluateLoop, name: str) -> None:
    """Raise ConfigError if there are too few boxes for an interval."""
    if command.boxes < 2:
        raise ConfigError(f"evaluate {name}: got {command.boxes} boxes, wanted 2 or more")


@contextmanager
def boxes_bar(what: str = "boxes") -> Iterator[Callable[[int, int], None]]:
    """Give a watcher that draws a bar on stderr."""
    columns = (
        TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    bar = Progress(*columns, console=Console(stderr=True))
    task = bar.add_task(what, total=None)

    def watch(done: int, total: int) -> None:
        bar.start()  # only now, so that what is refused before the first box is one line
        bar.update(task, total=total, completed=done)

    try:
        yield watch
    finally:
        if bar.live.is_started:
            bar.stop()

"""A bar on stderr while objects are made."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from viewgain.datasets import Progress as Done


@contextmanager
def bar(what: str) -> Iterator[Callable[[Done], None]]:
    """Give a watcher that draws a bar on stderr: done, rate, time left, failures."""
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(), TextColumn("skipped {task.fields[skipped]}"),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(what, total=None, rate="", skipped=0)

        def watch(done: Done) -> None:
            elapsed = bar.tasks[0].elapsed or 0.0
            rate = f"{done.samples / elapsed:,.1f} samples/s" if elapsed > 0 and done.samples else ""
            bar.update(task, total=done.total, completed=done.units, rate=rate, skipped=done.skipped)

        yield watch

"""``viewgain train``: a recipe and data in, a run folder out; and ``viewgain export``."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import torch
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from viewgain.cli._exit import DIVERGED, NOT_WRITTEN, print_error
from viewgain.cli._training_commands import Train
from viewgain.errors import ConfigError, MissingExtraError, StorageError
from viewgain.training import (
    REASONS,
    DistilSettings,
    Means,
    Outcome,
    Progress,
    RunFolder,
    TrainingRecipe,
    leads,
    resume,
    start,
    training_recipe,
)

PICTURE = "curves.png"
"""File of the loss curves in the run's folder."""


def run_train(command: Train) -> int:
    """Train; exit code 3 if a gradient is not finite, 4 if the folder cannot be written."""
    if bool(command.recipe) == (command.resume is not None):
        raise ConfigError("train: wanted either a recipe, or a run after --resume; see viewgain train --help")
    if command.threads < 1:
        raise ConfigError(f"train: got {command.threads} threads, wanted 1 or more")
    torch.set_num_threads(command.threads)
    means = Means(device=_device(command.device), minutes=command.minutes)
    try:
        return _go_on(command, command.resume, means) if command.resume is not None else _begin(command, means)
    except StorageError as error:
        print_error(error)
        return NOT_WRITTEN


def _begin(command: Train, means: Means) -> int:
    recipe = _changed(training_recipe(command.recipe), command)
    folder = command.out if command.out is not None else Path("runs") / recipe.name
    with _bar(recipe.training.iterations) as watch:
        outcome = start(recipe, folder, data=command.data, means=means, watch=watch)
    return _say(outcome, folder)


def _go_on(command: Train, folder: Path, means: Means) -> int:
    if any(each is not None for each in (command.out, command.target, command.iterations, command.seed)):
        raise ConfigError(
            "train: got --resume with --out, --target, --iterations or --seed, which are the run's own; leave them out"
        )
    with _bar(RunFolder(folder).read().recipe.training.iterations) as watch:
        outcome = resume(folder, data=command.data, teacher=command.teacher, means=means, watch=watch)
    return _say(outcome, folder)


def _changed(recipe: TrainingRecipe, command: Train) -> TrainingRecipe:
    """Return the recipe with what the command line says differently."""
    given = {name: value for name in ("iterations", "seed") if (value := getattr(command, name)) is not None}
    data = recipe.data if command.target is None else replace(recipe.data, target=command.target)
    distil = recipe.distil
    if command.teacher is not None:
        named = str(command.teacher)
        distil = DistilSettings(teacher=named) if distil is None else replace(distil, teacher=named)
    return replace(recipe, data=data, training=replace(recipe.training, **given), distil=distil)


def _device(name: str) -> str:
    if name == "cuda" and not torch.cuda.is_available():
        raise ConfigError("got --device cuda, and torch sees no GPU here; take auto or cpu")
    return ("cuda" if torch.cuda.is_available() else "cpu") if name == "auto" else name


def _say(outcome: Outcome, folder: Path) -> int:
    """Print how it ended, and draw the curves; of the processes of torchrun only the first one speaks."""
    if leads():
        _draw(folder)
        _print(outcome, folder)
    return DIVERGED if outcome.reason == "not_finite" else 0


def _print(outcome: Outcome, folder: Path) -> None:
    best = outcome.best
    if best is not None:
        shares = f"exact {best['exact']:.1%}, within 0.05 {best['within_0.05']:.1%} of {best['samples']:,} samples"
        print(f"{folder}: best weights are of step {best['step']:,}: {shares}")
    print(f"{folder}: ended after {outcome.step:,} steps: {REASONS[outcome.reason]}")


def _draw(folder: Path) -> None:
    """Draw the curves, where matplotlib is installed."""
    from viewgain.report import write_training_picture

    try:
        write_training_picture(RunFolder(folder).metrics(), folder / PICTURE)
    except MissingExtraError as error:
        print(f"no picture of the curves: {error}")


@contextmanager
def _bar(total: int) -> Iterator[Callable[[int, Progress], None]]:
    """Give a watcher that draws a bar on stderr: steps, speed, loss, best choice so far."""
    columns = (
        TextColumn("steps"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[words]}"),
        TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    with Bar(*columns, console=Console(stderr=True), disable=not leads()) as bar:
        task = bar.add_task("steps", total=total, words="")

        def watch(step: int, progress: Progress) -> None:
            bar.update(task, completed=step, words=_in_words(progress))

        yield watch


def _in_words(progress: Progress) -> str:
    words = []
    if progress.last:
        words += [f"loss {progress.last['loss']:.3g}", f"{progress.last['samples_per_second']:,.0f} samples/s"]
    if progress.best is not None:
        words.append(f"best exact {progress.best['exact']:.1%}")
    return ", ".join(words)

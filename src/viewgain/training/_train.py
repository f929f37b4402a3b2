"""Training a network, from top to bottom: step, log, validate, checkpoint, stop."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.training._checkpoint import Checkpoint, remove_old, step_path, write_checkpoint
from viewgain.training._examples import Examples
from viewgain.training._folder import RunFolder
from viewgain.training._ranks import Ranks
from viewgain.training._session import Session
from viewgain.training._validation import Validation, validate

Reason: TypeAlias = Literal["iterations", "minutes", "early_stop", "not_finite"]
"""Why a run ended: all steps made, the time limit, nothing better for long, or a gradient that is no number."""
REASONS: dict[Reason, str] = {
    "iterations": "all steps were made",
    "minutes": "the time limit was reached",
    "early_stop": "the validation objects saw nothing better for long",
    "not_finite": "the gradient is not finite; the weights before that step are kept: lower learning_rate, or set clip",
}
"""In words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How a run ended."""

    reason: Reason
    """Why."""
    step: int
    """Steps made, those of earlier parts of the run included."""
    best: dict[str, Any] | None
    """Figures of the best weights on the validation objects, with the step they are of; None if there was no validation."""


@dataclass(slots=True, kw_only=True)
class Progress:
    """Where the loop stands; what a checkpoint keeps of it is :meth:`state`."""

    best: dict[str, Any] | None = None
    """As :attr:`Outcome.best`."""
    stale: int = 0
    """Validations since the best one."""
    seconds: float = 0.0
    """Spent in the loop, earlier parts of the run included."""
    last: dict[str, Any] = field(default_factory=dict)
    """Latest line of metrics."""

    def state(self) -> dict[str, Any]:
        """Return what a checkpoint keeps."""
        return {"best": self.best, "stale": self.stale, "seconds": self.seconds}


Watcher = Callable[[int, Progress], None]
"""Told after every step: how many were made, and where the loop stands."""


def train(
    session: Session,
    folder: RunFolder,
    examples: Examples,
    held_out: NDArray[np.intp],
    *,
    ranks: Ranks,
    progress: Progress,
    minutes: float | None = None,
    watch: Watcher = lambda step, progress: None,
) -> Outcome:
    """Train until a reason to stop; metrics, checkpoints and the best weights are in the folder.

    Args:
        session: The network, fresh or restored.
        folder: Of the run; only process 0 writes.
        examples: All samples.
        held_out: Rows of those that are validated on.
        ranks: The processes that work together.
        progress: Where the loop stands; changed as it goes.
        minutes: Time limit of the whole run, earlier parts included; None for none.
        watch: Is told how far it is.

    Raises:
        StorageError: If something cannot be written.
    """
    settings = session.recipe.training
    clock = _Clock(progress, minutes)
    losses: list[float] = []
    reason: Reason = "iterations"
    while session.step < settings.iterations:
        loss = session.advance(clock=clock.share)
        if loss is None:
            reason = "not_finite"
            break
        losses.append(loss)
        watch(session.step, progress)
        last = session.step == settings.iterations
        if session.step % settings.log_every and not last:
            continue
        _log(session, folder, progress, ranks, losses, clock)
        losses.clear()
        if session.step % settings.validate_every == 0 or last:
            _validate(session, folder, progress, ranks, examples, held_out)
        clock.look(ranks, settings.checkpoint_minutes)
        if clock.is_due:
            _save(session, folder, progress, ranks)
        if settings.patience and progress.stale >= settings.patience:
            reason = "early_stop"
            break
        if clock.is_over:
            reason = "minutes"
            break
    if reason == "minutes" and progress.last.get("validated") != session.step:
        _validate(session, folder, progress, ranks, examples, held_out)
    _save(session, folder, progress, ranks)
    return Outcome(reason=reason, step=session.step, best=progress.best)


class _Clock:
    """Time as process 0 sees it, looked at only between lines of metrics, so that all processes agree."""

    def __init__(self, progress: Progress, minutes: float | None) -> None:
        self._before, self._start, self._saved = progress.seconds, time.monotonic(), time.monotonic()
        self._limit = math.inf if minutes is None else 60 * minutes
        self.share, self.is_due = min(1.0, self._before / self._limit), False

    @property
    def seconds(self) -> float:
        return self._before + time.monotonic() - self._start

    @property
    def is_over(self) -> bool:
        return self.share >= 1

    def look(self, ranks: Ranks, checkpoint_minutes: float) -> None:
        now = time.monotonic()
        share, since = ranks.leader_says([min(1.0, self.seconds / self._limit), now - self._saved])
        self.share, self.is_due = share, since >= 60 * checkpoint_minutes
        if self.is_due:
            self._saved = now


def _log(session: Session, folder: RunFolder, progress: Progress, ranks: Ranks, losses: list[float], clock: _Clock) -> None:
    """Write the mean loss since the last line. Everything but the seconds is the same on every run of a seed."""
    seconds = clock.seconds
    speed = len(losses) * session.recipe.training.batch / max(seconds - progress.seconds, 1e-9)
    progress.seconds = seconds
    progress.last = {
        "step": session.step,
        "loss": ranks.mean(sum(losses) / len(losses)),
        "learning_rate": session.rate,
        "seconds": round(seconds, 3),
        "samples_per_second": round(speed, 1),
    }
    if ranks.rank == 0:
        folder.append(progress.last)


def _validate(
    session: Session, folder: RunFolder, progress: Progress, ranks: Ranks, examples: Examples, rows: NDArray[np.intp]
) -> None:
    """Look at the validation objects in process 0, keep the best weights, and tell the others whether they are better."""
    found: Validation | None = None
    better = False
    if ranks.rank == 0:
        found = validate(session.judged, session.recipe, examples, rows)
        folder.append({"step": session.step, "validation": found.to_dict()})
        better = progress.best is None or _is_better(found.to_dict(), progress.best, session.recipe.training.watched)
    better = bool(ranks.leader_says([better])[0])
    progress.stale = 0 if better else progress.stale + 1
    progress.last = {**progress.last, "validated": session.step}
    if found is not None and better:
        progress.best = {"step": session.step, **found.to_dict()}
        write_checkpoint(folder.best, Checkpoint(tensors=session.weights(), state=progress.best))


def _is_better(found: dict[str, Any], best: dict[str, Any], watched: str) -> bool:
    return bool(found[watched] < best[watched] if watched == "loss" else found[watched] > best[watched])


def _save(session: Session, folder: RunFolder, progress: Progress, ranks: Ranks) -> None:
    if ranks.rank == 0:
        write_checkpoint(step_path(folder.checkpoints, session.step), session.checkpoint(progress.state()))
        remove_old(folder.checkpoints)

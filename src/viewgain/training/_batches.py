"""Batches by the number of the step: order, drawn points and augmentation follow from the seed and the step alone.

So how many steps were made is the whole state of the data, and every process of a distributed run knows the whole batch.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from viewgain.datasets import ShuffledOrder
from viewgain.training._examples import Examples
from viewgain.training._moved import moved_alike
from viewgain.training._settings import DataSettings
from viewgain.training._symmetry import LOST, Symmetries

_LARGE = 1 << 62
"""Seeds of torch's generators stay under this."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Batch:
    """What one step is made of."""

    points: Tensor
    """(B, n, 3) float32; zero where there is no point."""
    mask: Tensor
    """(B, n) bool: where there is one."""
    states: Tensor | None
    """(B, V) float32, 1 for visited views, in rig order; None for networks that are not told."""
    targets: Tensor
    """(B, V) float32: in rig order with states, else with the present view first."""
    views: Tensor
    """(B,) int64: the present view."""
    taught: Tensor | None = None
    """(B, V) float32: a teacher's scores in the same order; None without a teacher."""
    candidates: Tensor | None = None
    """(B, V, 4, 4) float32: the candidates' poses in the present camera; None for networks that are not told."""
    valid: Tensor | None = None
    """(B, V) bool: candidates that count; None for all."""

    @property
    def told(self) -> Tensor | None:
        """What the network is told beside the cloud."""
        return self.states if self.candidates is None else self.candidates


class Labels(Protocol):
    """Who gives scores beside those of the data set: :class:`viewgain.training.Teacher`."""

    @property
    def points(self) -> int:
        """Points of a cloud that are looked at."""

    def scores(self, points: Tensor, mask: Tensor, states: Tensor, views: Tensor) -> Tensor:
        """Return (B, V) scores in the order of the targets; arguments as :meth:`viewgain.training.Teacher.scores`."""


class Batches:
    """The training batches of some samples."""

    def __init__(
        self,
        examples: Examples,
        settings: DataSettings,
        *,
        rows: NDArray[np.intp],
        batch: int,
        points: int,
        uses_state: bool,
        seed: int,
        symmetries: Symmetries | None = None,
        teacher: Labels | None = None,
    ) -> None:
        """Take some samples; ``symmetries`` are drawn from where they are given.

        Args:
            examples: All samples.
            settings: The recipe's table: noise and hidden points.
            rows: Those of them that train.
            batch: Samples per step.
            points: Points of each.
            uses_state: Whether the network is told which views were visited.
            seed: Source of order and draws.
            symmetries: Motions to show the samples under.
            teacher: Labels every batch once more.
        """
        self._examples, self._settings, self._rows = examples, settings, torch.from_numpy(rows)
        self._batch, self._points, self._uses_state, self._seed = batch, points, uses_state, seed
        self._teacher = teacher
        self._order = ShuffledOrder(len(rows), seed=seed)
        self._epoch = lru_cache(maxsize=2)(self._order.epoch)
        self._device = examples.points.device
        self._maps = self._carried = None
        if symmetries is not None:
            self._maps = torch.from_numpy(symmetries.maps).float().to(self._device)
            self._carried = torch.from_numpy(symmetries.carried).to(self._device)

    def at(self, step: int, *, part: slice = slice(None)) -> Batch:
        """Return the batch of a step, or the part of it that one process works on."""
        places = np.arange(step * self._batch, (step + 1) * self._batch)
        epochs, positions = np.divmod(places, len(self._rows))
        inside = np.array([self._epoch(int(epoch))[position] for epoch, position in zip(epochs, positions, strict=True)])
        rows = self._rows[torch.from_numpy(inside)].to(self._device)
        generator = self._generator(step)
        clouds, mask = drawn_points(self._examples, rows, self._points, generator)
        # By the same draw, so that of student and teacher the one with fewer points has the first ones of the other.
        shown = None if self._teacher is None else drawn_points(self._examples, rows, self._teacher.points, self._generator(step))
        views, states, targets = (each[rows] for each in (self._examples.views, self._examples.states, self._examples.targets))
        candidates, valid = (None if each is None else each[rows] for each in (self._examples.candidates, self._examples.valid))
        motions = self._motions(views, generator)
        if motions is not None:
            turns, carried = motions
            clouds = clouds @ turns
            shown = None if shown is None else (shown[0] @ turns, shown[1])
            views = carried.gather(1, views[:, None])[:, 0]
            valid = _moved(torch.ones_like(states), carried) if bool((carried == LOST).any()) else None
            states, targets = _moved(states, carried), _moved(targets, carried)
        taught = None
        if self._teacher is not None and shown is not None:
            taught = self._teacher.scores(shown[0][part], shown[1][part], states[part], views[part])
        if candidates is not None:
            clouds, candidates = moved_alike(clouds, mask, candidates, self._settings, generator)
        clouds, mask = self._disturbed(clouds, mask, generator)
        whole = _batch(clouds, mask, views, states, targets, valid, uses_state=self._uses_state)
        return Batch(
            points=whole.points[part],
            mask=whole.mask[part],
            states=None if whole.states is None else whole.states[part],
            targets=whole.targets[part],
            views=whole.views[part],
            taught=taught,
            candidates=None if candidates is None else candidates[part],
            valid=None if whole.valid is None else whole.valid[part],
        )

    def _generator(self, step: int) -> torch.Generator:
        return torch.Generator(self._device).manual_seed((self._seed * 1_000_003 + step) % _LARGE)

    def _motions(self, views: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor] | None:
        """Return (B, 3, 3) what rows of points are multiplied by, and (B, V) where views are carried to; None for no motions.

        Where the present view would get lost, all stays as it is.
        """
        if self._maps is None or self._carried is None:
            return None
        which = torch.randint(len(self._carried), (len(views),), generator=generator, device=self._device)
        which = torch.where(self._carried[which, views] == LOST, 0, which)
        return self._maps[which, views].transpose(1, 2), self._carried[which]

    def _disturbed(self, clouds: Tensor, mask: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
        """Return clouds with noise and with hidden points; of each at least its first point stays."""
        if self._settings.jitter:
            noise = torch.empty_like(clouds).normal_(generator=generator)
            clouds = (clouds + self._settings.jitter * noise) * mask[..., None]
        if self._settings.dropout:
            share = torch.rand(len(clouds), 1, generator=generator, device=clouds.device) * self._settings.dropout
            hidden = torch.rand(mask.shape, generator=generator, device=clouds.device) < share
            hidden[:, 0] = False
            mask = mask & ~hidden
            clouds = clouds * mask[..., None]
        return clouds, mask


def in_order(
    examples: Examples, rows: NDArray[np.intp], *, batch: int, points: int, uses_state: bool
) -> Iterator[tuple[NDArray[np.intp], Batch]]:
    """Yield rows and batches of some samples as they are, one after the other: always the same points, no augmentation."""
    for start in range(0, len(rows), batch):
        chosen = rows[start : start + batch]
        index = torch.from_numpy(chosen).to(examples.points.device)
        clouds = examples.points[index, :points].float()
        mask = torch.arange(clouds.shape[1], device=clouds.device)[None] < examples.counts[index, None]
        views, states, targets = (each[index] for each in (examples.views, examples.states, examples.targets))
        candidates, valid = (None if each is None else each[index] for each in (examples.candidates, examples.valid))
        whole = _batch(clouds, mask, views, states, targets, valid, uses_state=uses_state)
        yield chosen, replace(whole, candidates=candidates)


def drawn_points(examples: Examples, rows: Tensor, points: int, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Return (B, n, 3) points, each of a cloud at most once, and (B, n) where there are any.

    Args:
        examples: All samples.
        rows: (B,) of which.
        points: n at most; fewer where no cloud has so many.
        generator: Of torch, on the device of the samples.
    """
    clouds, counts = examples.points[rows], examples.counts[rows]
    held = clouds.shape[1]
    place = torch.arange(held, device=clouds.device)[None]
    if held <= points:
        return clouds.float(), place < counts[:, None]
    keys = torch.rand(len(rows), held, generator=generator, device=clouds.device)
    keys = torch.where(place < counts[:, None], keys, 2.0)
    chosen = keys.topk(points, dim=1, largest=False).indices
    mask = chosen < counts[:, None]
    return clouds.gather(1, chosen[..., None].expand(-1, -1, 3)).float() * mask[..., None], mask


def _batch(
    points: Tensor, mask: Tensor, views: Tensor, states: Tensor, targets: Tensor, valid: Tensor | None, *, uses_state: bool
) -> Batch:
    if uses_state:
        return Batch(points=points, mask=mask, states=states.float(), targets=targets, views=views, valid=valid)
    first = None if valid is None else present_first(valid, views)
    return Batch(points=points, mask=mask, states=None, targets=present_first(targets, views), views=views, valid=first)


def _moved(values: Tensor, carried: Tensor) -> Tensor:
    """Return (B, V) values at the views that those of (B, V) are carried to; 0 at places left vacant."""
    count = values.shape[1]
    places = torch.where(carried == LOST, count, carried)  # a column behind the others, which is cut off
    return values.new_zeros(len(values), count + 1).scatter(1, places, values)[:, :count]


def present_first(scores: Tensor, views: Tensor) -> Tensor:
    """Return (B, V) scores in rig order with each row's present view (B,) first: row by row ``np.roll(scores, -view)``."""
    count = scores.shape[1]
    return scores.gather(1, (torch.arange(count, device=scores.device)[None] + views[:, None]) % count)

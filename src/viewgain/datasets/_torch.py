"""Samples as tensors, in an order that can be left and taken up again. torch is loaded when the first tensor is made.

What comes out for a place in the order depends on the seed and the place alone: not on the worker, nor on where training stopped.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from viewgain.datasets._augment import NO_AUGMENTATION, Augmentation
from viewgain.datasets._dataset import Dataset
from viewgain.errors import ConfigError

if TYPE_CHECKING:  # torch is an extra
    from torch import Tensor


class ShuffledOrder:
    """An endless deterministic order of samples, epoch after epoch. How many were consumed is the whole state."""

    def __init__(self, count: int, *, seed: int = 0, consumed: int = 0) -> None:
        """Start after ``consumed`` samples.

        Raises:
            ConfigError: If there is nothing to order, or ``consumed`` is negative.
        """
        if count < 1 or consumed < 0:
            raise ConfigError(f"order: got {count} samples, {consumed} consumed; wanted 1 or more, and 0 or more")
        self._count, self._seed, self._consumed = count, seed, consumed

    def __len__(self) -> int:
        """Return how many samples are left in this epoch."""
        return self._count - self._consumed % self._count

    def __iter__(self) -> Iterator[int]:
        """Yield places for :class:`TorchDataset`, from here to the end of the epoch: ``epoch * count + index``."""
        epoch, position = divmod(self._consumed, self._count)
        for index in self.epoch(epoch)[position:].tolist():
            yield epoch * self._count + index

    def epoch(self, number: int) -> NDArray[np.intp]:
        """Return the (count,) order of one epoch."""
        return np.random.default_rng([self._seed, number]).permutation(self._count)

    def after(self, consumed: int) -> "ShuffledOrder":
        """Return the same order after so many samples since its very start: what a checkpoint has to keep."""
        return ShuffledOrder(self._count, seed=self._seed, consumed=consumed)


class TorchDataset:
    """A map-style dataset for torch's ``DataLoader``; :class:`ShuffledOrder` is its sampler, :func:`collated` makes batches."""

    def __init__(
        self,
        data: Dataset,
        *,
        indices: Sequence[int] | NDArray[np.intp] | None = None,
        points: int = 512,
        augmentation: Augmentation = NO_AUGMENTATION,
        seed: int = 0,
    ) -> None:
        """Take some samples of a data set.

        Args:
            data: The data set.
            indices: Which samples, for instance ``data.part("other_box", "train")``; None for all.
            points: How many points each is resampled to; 0 for as many as it has.
            augmentation: What is changed about them.
            seed: Source of the resampling and the augmentation.
        """
        self._data, self._points, self._augmentation, self._seed = data, points, augmentation, seed
        self._indices = np.arange(len(data)) if indices is None else np.asarray(indices)

    def __len__(self) -> int:
        return len(self._indices)

    def __getitem__(self, place: int) -> "dict[str, Tensor]":
        """Return the tensors of a place: index ``place % len(self)``, drawn anew for each epoch ``place // len(self)``.

        Returns:
            ``points`` (n, 3), ``candidates`` (V, 4, 4), ``state`` and ``reachable`` (V,), ``view``, ``object``, ``index`` and
            ``target_NAME`` (V,) for every target of the data set. Candidates come with the present view first.
        """
        import torch

        epoch, row = divmod(int(place), len(self))
        index = int(self._indices[row])
        rng = np.random.default_rng([self._seed, epoch, index])
        sample = self._data[index]
        if self._augmentation != NO_AUGMENTATION:
            sample = self._augmentation.apply(sample, rng=rng)
        if self._points:
            sample = sample.resampled(self._points, rng=rng)
        arrays: dict[str, NDArray[Any]] = {
            "points": sample.points,
            "candidates": sample.candidates.astype(np.float32),
            "state": sample.state.copy(),
            "reachable": sample.reachable.copy(),
            "view": np.array(sample.view),
            "object": np.array(sample.object),
            "index": np.array(index),
        }
        arrays |= {f"target_{name}": np.array(scores, dtype=np.float32) for name, scores in sample.targets.items()}
        return {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}


def collated(rows: "Sequence[dict[str, Tensor]]") -> "dict[str, Tensor]":
    """Return a batch: what varies in length (points, candidates) is padded with zeros.

    ``points_mask`` (B, n) and ``candidates_mask`` (B, V) say which entries are real.
    """
    import torch
    from torch.nn.utils.rnn import pad_sequence

    batch = {}
    for name in rows[0]:
        each = [row[name] for row in rows]
        batch[name] = pad_sequence(each, batch_first=True) if each[0].ndim else torch.stack(each)
    for name in ("points", "candidates"):
        masks = [torch.ones(len(row[name]), dtype=torch.bool) for row in rows]
        batch[f"{name}_mask"] = pad_sequence(masks, batch_first=True)
    return batch

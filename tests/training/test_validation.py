"""Validation counts as the evaluation does: equal views are equally right, visited ones are never chosen."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from tests.training.conftest import changed
from viewgain.datasets import Dataset
from viewgain.training import Examples, load_examples, validate


class Fixed(nn.Module):
    """Gives every cloud the same scores."""

    def __init__(self, scores: list[float]) -> None:
        super().__init__()
        self.scores = torch.tensor(scores)

    def forward(self, points: Tensor, mask: Tensor, states: Tensor | None) -> Tensor:
        return self.scores.expand(len(points), -1)


def with_targets(data: Dataset, gains: list[float]) -> Examples:
    """Return samples that all have the same gains, present view first."""
    recipe = changed()
    examples = load_examples(data, recipe.data, views=16, seed=0)
    rolled = np.stack([np.roll(gains, int(view)) for view in examples.views])
    return replace(examples, targets=torch.from_numpy(rolled.astype(np.float32)))


def test_equal_views_are_equally_right_and_the_present_one_is_never_chosen(data: Dataset) -> None:
    gains = [0.9, 0.5, 0.2, 0.5 - 4e-7, 0.46] + [0.0] * 11
    examples, rows = with_targets(data, gains), np.arange(10)
    for best, exact, within in [(3, 1.0, 1.0), (1, 1.0, 1.0), (4, 0.0, 1.0), (2, 0.0, 0.0)]:
        scores = [9.0] + [1.0 * (view == best) for view in range(1, 16)]
        found = validate(Fixed(scores), changed(), examples, rows).to_dict()
        assert (found["exact"], found["within_0.05"], found["samples"]) == (exact, within, 10)
        assert found["within_0.01"] == exact
    assert found["loss"] == pytest.approx(float(np.mean(np.subtract(scores, gains) ** 2)), rel=1e-5)

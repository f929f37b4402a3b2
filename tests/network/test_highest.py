"""The maximum over neighbours: with a gradient and without, the same values, and the gradient of the plain maximum."""

import pytest
import torch

from viewgain.network._layers import highest_of
from viewgain.network._neighbours import gathered, highest


def test_highest_is_the_maximum_over_neighbours_with_its_gradient() -> None:
    generator = torch.Generator().manual_seed(1)
    features = torch.randn(3, 20, 5, generator=generator).requires_grad_()
    rows = torch.randint(0, 20, (3, 20, 4), generator=generator) + 20 * torch.arange(3)[:, None, None]
    weights = torch.randn(3, 20, 5, generator=generator)
    plain = gathered(features, rows).amax(2)
    (wanted,) = torch.autograd.grad((plain * weights).sum(), features)
    found = highest(features, rows)
    (got,) = torch.autograd.grad((found * weights).sum(), features)
    assert torch.equal(found, plain)
    torch.testing.assert_close(got, wanted, rtol=0, atol=1e-5)  # sums of a few numbers in another order
    with torch.inference_mode():
        assert torch.equal(highest(features, rows), plain)


def test_of_equal_neighbours_one_gets_the_gradient() -> None:
    features = torch.zeros(1, 3, 1, requires_grad=True)
    highest(features, torch.tensor([[[1, 2], [0, 2], [0, 1]]])).sum().backward()
    assert features.grad is not None
    assert float(features.grad.sum()) == 3


@pytest.mark.parametrize("dim", [1, 2])
def test_the_maximum_along_a_dimension_has_the_gradient_of_the_plain_one(dim: int) -> None:
    generator = torch.Generator().manual_seed(2)
    values = torch.randn(3, 7, 5, 4, generator=generator).requires_grad_()
    weights = torch.randn_like(values.amax(dim))
    (wanted,) = torch.autograd.grad((values.amax(dim) * weights).sum(), values)
    found = highest_of(values, dim)
    (got,) = torch.autograd.grad((found * weights).sum(), values)
    assert torch.equal(found, values.amax(dim))
    assert torch.equal(got, wanted)
    with torch.inference_mode():
        assert torch.equal(highest_of(values, dim), values.amax(dim))


def test_of_equal_values_one_gets_the_gradient() -> None:
    values = torch.zeros(2, 3, 4, requires_grad=True)
    highest_of(values, 1).sum().backward()
    assert values.grad.sum(1).tolist() == [[1.0] * 4] * 2
    assert values.grad.max() == 1

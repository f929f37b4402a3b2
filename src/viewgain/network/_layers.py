"""Layers of PC-NBV, per cloud. What is the same for all edges of a point, or for all points of a cloud, is computed once.

Each is equal to its textbook form (tests/oracles/network.py), which first lays (B, N, k, 2C) or repeated columns into memory.
"""

import itertools
from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn.functional import linear

from viewgain.network._neighbours import gathered


class DenseEdgeConv(nn.Module):
    """Three layers on the edges to a point's neighbours, each fed with all before it, then the maximum over the edges.

    An edge starts as (x_i, x_j - x_i). Since W (x_i, x_j - x_i) = (W1 - W2) x_i + W2 x_j, points are projected first and only
    the ``growth`` channels of the result are gathered along edges; the same goes for the x_i that enters the later layers.

    Shapes: (B, N, C) and rows (B, N, k) to (B, N, C + 3 growth).

    Source: Yifan et al. 2019 as used by Zeng et al. 2020 (the last layer has no activation).
    """

    def __init__(self, channels: int, growth: int) -> None:
        """Take the channels of a point and those that each layer adds."""
        super().__init__()
        self.growth = growth
        self.first = nn.Linear(2 * channels, growth)
        self.middle = nn.Linear(growth + channels, growth)
        self.last = nn.Linear(2 * growth + channels, growth)

    def forward(self, features: Tensor, rows: Tensor) -> Tensor:
        """Return the features of :class:`DenseEdgeConv`; ``rows`` as :func:`nearest` gives them."""
        growth, channels = self.growth, features.shape[-1]
        own, offset = columns(self.first.weight, channels, channels)
        to_edges, of_point = columns(self.middle.weight, growth, channels)
        of_middle, of_first, of_own = columns(self.last.weight, growth, growth, channels)
        here = linear(features, own - offset, self.first.bias)
        first = torch.relu(here[:, :, None] + gathered(linear(features, offset), rows))  # (B, N, k, growth)
        here = linear(features, of_point, self.middle.bias)
        middle = torch.relu(here[:, :, None] + linear(first, to_edges))
        last = highest_of(linear(middle, of_middle) + linear(first, of_first), 2) + linear(features, of_own, self.last.bias)
        return torch.cat((last, highest_of(middle, 2), highest_of(first, 2), features), dim=-1)


def columns(weight: Tensor, *widths: int) -> tuple[Tensor, ...]:
    """Return the parts of a weight (out, in) that act on the first ``widths[0]`` inputs, on the next ``widths[1]``, ..."""
    ends = list(itertools.accumulate(widths))
    return tuple(weight[:, end - width : end] for width, end in zip(widths, ends, strict=True))


class SplitLinear(nn.Linear):
    """A linear layer on points beside which stands one feature of their cloud; equal to a layer on (point, cloud) joined.

    Shapes: (B, N, L) and (B, S) to (B, N, out).
    """

    def forward(self, points: Tensor, cloud: Tensor) -> Tensor:  # type: ignore[override]
        """Return the layer's output before any activation."""
        of_point, of_cloud = columns(self.weight, points.shape[-1], cloud.shape[-1])
        return linear(points, of_point) + linear(cloud, of_cloud, self.bias)[:, None]


class SelfAttention(nn.Module):
    """Every point looks at all points of its own cloud; what it sees is added with a learned weight that starts at zero.

    Shapes: (B, N, L), (B, S) and a mask (B, N) to (B, N, L + S).

    Source: Zhang et al. 2019 as used by Zeng et al. 2020: projections with activation, no scaling. Differs: the public code
    lays all clouds of a batch end to end and attends across them; here each cloud is alone.
    """

    def __init__(self, channels: int) -> None:
        """Take the channels of a point, those of the cloud included."""
        super().__init__()
        self.query = SplitLinear(channels, channels // 4)
        self.key = SplitLinear(channels, channels // 4)
        self.value = SplitLinear(channels, channels)
        self.gamma = nn.Parameter(torch.zeros(1))

    def forward(self, points: Tensor, cloud: Tensor, mask: Tensor) -> Tensor:
        """Return the points with what they saw."""
        query, key, value = (torch.relu(layer(points, cloud)) for layer in (self.query, self.key, self.value))
        likeness = (query @ key.transpose(1, 2)).masked_fill(~mask[:, None, :], -torch.inf)  # (B, N, N)
        seen = torch.softmax(likeness, dim=-1) @ value
        joined = torch.cat((points, cloud[:, None].expand(-1, points.shape[1], -1)), dim=-1)
        return joined + self.gamma * seen


class Perceptron(nn.Sequential):
    """Linear layers with an activation between them and none after the last."""

    def __init__(self, widths: Sequence[int]) -> None:
        """Take the width of the input, then that of each layer."""
        layers: list[nn.Module] = []
        for inputs, outputs in itertools.pairwise(widths):
            layers += [nn.Linear(inputs, outputs), nn.ReLU()]
        super().__init__(*layers[:-1])


def pooled(features: Tensor, mask: Tensor) -> Tensor:
    """Return (B, C) the maximum of (B, N, C) over the real points of each cloud."""
    return highest_of(features.masked_fill(~mask[..., None], -torch.inf), 1)


def highest_of(values: Tensor, dim: int) -> Tensor:
    """Return the maximum along a dimension.

    Where a gradient is wanted, it flows to one of equal values: to share it, as ``amax`` does, all values are compared once more.
    """
    if torch.is_grad_enabled() and values.requires_grad:
        return values.max(dim).values
    return values.amax(dim)

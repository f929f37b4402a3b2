"""The compact networks: the same question and answer as PC-NBV at a fraction of its time (ours).

What PC-NBV spends its time on is 1024 x 1024 numbers per point, attention between all points, and four searches for neighbours
in feature space. Here there is one search, in space, and edges carry no layers of their own: a layer on edges followed by a
maximum, max_j (A x_i + B x_j), is A x_i + max_j B x_j, so B x is computed per point and only its maximum is taken along edges.
"""

import torch
from torch import Tensor, nn

from viewgain.network._inputs import ScoreNetwork, joined
from viewgain.network._layers import Perceptron, SplitLinear, pooled
from viewgain.network._neighbours import highest, nearest_in_space
from viewgain.network._output import outputs_of, shaped
from viewgain.network._settings import NetworkSettings


class EdgeMax(nn.Module):
    """An edge convolution of one layer: relu of the maximum over neighbours of W (x_i, x_j).

    Shapes: (B, N, C) and rows (B, N, k) to (B, N, out).
    """

    def __init__(self, channels: int, outputs: int) -> None:
        """Take the channels of a point before and after."""
        super().__init__()
        self.own = nn.Linear(channels, outputs)
        self.other = nn.Linear(channels, outputs, bias=False)

    def forward(self, features: Tensor, rows: Tensor) -> Tensor:
        """Return the features of :class:`EdgeMax`; ``rows`` as :func:`nearest` gives them."""
        return torch.relu(self.own(features) + highest(self.other(features), rows))


class Compact(ScoreNetwork):
    """Three edge convolutions on one graph, the cloud's feature shown back to its points, maximum, scores."""

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the settings; the parameters are set by :func:`viewgain.network.build`."""
        super().__init__(settings)
        width = settings.width
        self.lift = nn.Linear(3, width)
        self.edges = nn.ModuleList((EdgeMax(width, width), EdgeMax(width, width), EdgeMax(width, 2 * width)))
        self.local = nn.Linear(5 * width, 3 * width)
        self.beside = SplitLinear(6 * width + (settings.views if settings.with_view_state else 0), 3 * width)
        self.wide = nn.Linear(3 * width, 6 * width)
        self.head = Perceptron((6 * width, 4 * width, 2 * width, outputs_of(settings)))

    def scored(self, points: Tensor, mask: Tensor, view_state: Tensor | None) -> Tensor:
        """Return the scores."""
        rows = nearest_in_space(points, mask, self.settings.neighbours)
        layers = [torch.relu(self.lift(points))]
        for edge in self.edges:
            layers.append(edge(layers[-1], rows))
        local = torch.relu(self.local(torch.cat(layers, dim=-1)))  # (B, N, 3 width)
        beside = torch.relu(self.beside(local, joined(pooled(local, mask), view_state)))
        cloud = torch.relu(pooled(self.wide(beside), mask))  # (B, 6 width)
        return shaped(self.head(cloud), self.settings)

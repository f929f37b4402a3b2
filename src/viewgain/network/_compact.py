"""The compact networks: the same question and answer as PC-NBV at a fraction of its time (ours).

What PC-NBV spends its time on is 1024 x 1024 numbers per point, attention between all points, and four searches for neighbours
in feature space. Here there is one search, in space, and edges carry no layers of their own: a layer on edges followed by a
maximum, max_j (A x_i + B x_j), is A x_i + max_j B x_j, so B x is computed per point and only its maximum is taken along edges.
"""

import torch
from torch import Tensor, nn

from viewgain.network._inputs import prepared
from viewgain.network._layers import Perceptron, SplitLinear, pooled
from viewgain.network._neighbours import gathered, nearest
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
        return torch.relu(self.own(features) + gathered(self.other(features), rows).amax(2))


class Compact(nn.Module):
    """Three edge convolutions on one graph, the cloud's feature shown back to its points, maximum, scores.

    Shapes: as :class:`viewgain.network.PcNbv`.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the settings; the parameters are set by :func:`viewgain.network.build`."""
        super().__init__()
        self.settings = settings
        width = settings.width
        self.lift = nn.Linear(3, width)
        self.edges = nn.ModuleList((EdgeMax(width, width), EdgeMax(width, width), EdgeMax(width, 2 * width)))
        self.local = nn.Linear(5 * width, 4 * width)
        self.beside = SplitLinear(8 * width + (settings.views if settings.with_view_state else 0), 4 * width)
        self.wide = nn.Linear(4 * width, 8 * width)
        self.head = Perceptron((8 * width, 4 * width, 2 * width, outputs_of(settings)))

    def forward(self, points: Tensor, mask: Tensor | None = None, view_state: Tensor | None = None) -> Tensor:
        """Return scores; inputs, order and errors as :meth:`viewgain.network.PcNbv.forward`."""
        mask, state = prepared(points, mask, view_state, self.settings)
        rows = nearest(points, mask, self.settings.neighbours)
        layers = [torch.relu(self.lift(points))]
        for edge in self.edges:
            layers.append(edge(layers[-1], rows))
        local = torch.relu(self.local(torch.cat(layers, dim=-1)))  # (B, N, 4 width)
        cloud = pooled(local, mask) if state is None else torch.cat((pooled(local, mask), state), dim=-1)
        beside = torch.relu(self.beside(local, cloud))
        return shaped(self.head(torch.relu(pooled(self.wide(beside), mask))), self.settings)

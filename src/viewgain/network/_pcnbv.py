"""PC-NBV, with and without the view state. Pop and Tamas 2022, section 3.1 and Fig. 7; Zeng et al. 2020.

Read ``scored`` from top to bottom beside Fig. 7: features of points, the cloud's, attention, shared layers, maximum, scores.
"""

import torch
from torch import Tensor, nn

from viewgain.network._inputs import ScoreNetwork, joined
from viewgain.network._layers import DenseEdgeConv, Perceptron, SelfAttention, pooled
from viewgain.network._neighbours import leaning, nearest
from viewgain.network._output import outputs_of, shaped
from viewgain.network._settings import NetworkSettings


class FeatureExtraction(nn.Module):
    """Dense edge convolutions, each on the neighbours in its own feature space, each passing on all that came before.

    Shapes: (B, N, 3) and a mask (B, N) to (B, N, 2 growth + blocks * 5 growth): 24, 84, 144, 204, 264 channels.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the sizes."""
        super().__init__()
        width, added = 2 * settings.growth, 5 * settings.growth
        self.neighbours = settings.neighbours
        self.channels = width + settings.blocks * added
        self.lift = nn.Linear(3, width)
        self.narrow = nn.ModuleList(nn.Linear(width + block * added, width) for block in range(1, settings.blocks))
        self.blocks = nn.ModuleList(DenseEdgeConv(width, settings.growth) for _ in range(settings.blocks))

    def forward(self, points: Tensor, mask: Tensor) -> Tensor:
        """Return the features of all points."""
        outer: Tensor = self.lift(points)
        lean = leaning(points)
        inner = outer
        for index, block in enumerate(self.blocks):
            if index:
                inner = torch.relu(self.narrow[index - 1](outer))
            outer = torch.cat((block(inner, nearest(inner, mask, self.neighbours, lean)), outer), dim=-1)
        return outer


class PcNbv(ScoreNetwork):
    """PC-NBV.

    Source: Zeng et al. 2020; without the view state Pop and Tamas 2022. Their public code feeds that network a constant view
    state, which is a bias; here the columns are left out.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the settings; the parameters are set by :func:`viewgain.network.build`."""
        super().__init__(settings)
        self.features = FeatureExtraction(settings)
        channels = 2 * self.features.channels + (settings.views if settings.with_view_state else 0)
        self.attention = SelfAttention(channels)
        self.shared = Perceptron((channels, *settings.shared))
        self.head = Perceptron((settings.shared[-1], *settings.head, outputs_of(settings)))

    def scored(self, points: Tensor, mask: Tensor, view_state: Tensor | None) -> Tensor:
        """Return the scores, one step of Fig. 7 per line."""
        local = self.features(self.standardised(points), mask)  # (B, N, 264)
        cloud = joined(pooled(local, mask), view_state)  # (B, 264 (+ V))
        seen = self.attention(local, cloud, mask)  # (B, N, 528 (+ V))
        return shaped(self.head(pooled(self.shared(seen), mask)), self.settings)

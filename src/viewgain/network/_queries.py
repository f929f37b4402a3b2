"""Every candidate view asks the cloud: attention from views to points."""

import torch
from torch import Tensor, nn

from viewgain.network._evenness import STATISTICS
from viewgain.network._hierarchy import Impression

HEADS = 4
"""Parts of the channels that attend each on their own."""
SHARP = 20.0
"""Statistics of evenness differ by tenths between views, and are to move logits by several."""


class ViewQueries(nn.Module):
    """What each view learns from the cloud as a whole, then from its coarse and from its fine points.

    Shapes: an impression of the cloud and a view state (B, V) or None to (B, V, 4 width).

    Source: attention as in Vaswani et al. 2017; one learned query per view, ours. With a view state a query knows which views
    were visited, and whether its own was; which of the views that is, it has learned.
    """

    def __init__(self, views: int, width: int, *, told: bool) -> None:
        """Take V, the width of the network, and whether there is a view state."""
        super().__init__()
        self.view = nn.Parameter(torch.empty(views, 4 * width))
        self.whole = nn.Linear(8 * width + (views + 1 if told else 0), 4 * width)
        self.inquiry = Inquiry(4 * width, coarse=8 * width + 3, fine=4 * width + 3)

    def forward(self, cloud: Impression, view_state: Tensor | None) -> Tensor:
        """Return what each view has learned."""
        known = cloud.whole[:, None].expand(-1, len(self.view), -1)
        if view_state is not None:
            everywhere = view_state[:, None].expand(-1, len(self.view), -1)
            known = torch.cat((known, everywhere, view_state[..., None]), dim=-1)
        queries = self.view + self.whole(known)
        queries = queries if cloud.seen is None else queries + cloud.seen
        return torch.as_tensor(self.inquiry(queries, cloud.levels.far, cloud.levels.near))


class Guess(nn.Module):
    """From which view of the rig was the cloud seen? An impression of it to (B, V) logits.

    What is learned of shapes, and how evenly the points lie in each image, count as independent evidence: logits add up.
    """

    def __init__(self, views: int, width: int, *, placed: bool) -> None:
        """Take V, the width of the network, and whether views know where they stand."""
        super().__init__()
        self.queries = ViewQueries(views, width, told=False)
        self.presence = nn.Linear(4 * width, 1)
        self.even = nn.Linear(len(STATISTICS), 1, bias=False) if placed else None

    def forward(self, cloud: Impression) -> Tensor:
        """Return the logits."""
        logits = self.presence(self.queries(cloud, None))
        if self.even is not None and cloud.even is not None:
            logits = logits + SHARP * self.even(cloud.even)
        return torch.as_tensor(logits[..., 0])


class Inquiry(nn.Module):
    """Queries (B, V, Q) ask the coarse points (B, M, C), think, and ask the fine ones (B, L, D): (B, V, Q)."""

    def __init__(self, width: int, *, coarse: int, fine: int) -> None:
        """Take Q, C and D."""
        super().__init__()
        self.coarse, self.fine = Ask(width, coarse), Ask(width, fine)
        self.think = nn.Sequential(nn.Linear(width, 2 * width), nn.ReLU(), nn.Linear(2 * width, width))

    def forward(self, queries: Tensor, coarse: Tensor, fine: Tensor) -> Tensor:
        """Return what each query has learned."""
        queries = queries + self.coarse(queries, coarse)
        queries = queries + self.think(queries)
        return torch.relu(queries + self.fine(queries, fine))


class Ask(nn.Module):
    """Attention of queries (B, V, Q) to points (B, N, C), in parts: (B, V, Q)."""

    def __init__(self, width: int, channels: int) -> None:
        """Take Q and C."""
        super().__init__()
        self.key = nn.Linear(channels, width, bias=False)  # a bias adds as much to all points, which softmax does not see
        self.value = nn.Linear(channels, width)
        self.out = nn.Linear(width, width)

    def forward(self, queries: Tensor, points: Tensor) -> Tensor:
        """Return what each query finds."""
        asked, keys, values = (_parted(each) for each in (queries, self.key(points), self.value(points)))
        likeness = asked @ keys.transpose(2, 3) / asked.shape[-1] ** 0.5  # (B, heads, V, N)
        found = torch.softmax(likeness, dim=-1) @ values
        return torch.as_tensor(self.out(found.transpose(1, 2).flatten(2)))


def _parted(features: Tensor) -> Tensor:
    """Return (B, heads, N, C / heads) of (B, N, C)."""
    batch, number, channels = features.shape
    return features.reshape(batch, number, HEADS, channels // HEADS).transpose(1, 2)

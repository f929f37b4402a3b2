"""Every candidate view asks the cloud: attention from views to points."""

import torch
from torch import Tensor, nn

HEADS = 4
"""Parts of the channels that attend each on their own."""


class ViewQueries(nn.Module):
    """What each view learns from the cloud as a whole, then from its coarse and from its fine points.

    Shapes: cloud (B, S), coarse (B, M, C), fine (B, L, D) and a view state (B, V) or None to (B, V, width).

    Source: attention as in Vaswani et al. 2017; one learned query per view, ours. A query knows which views were visited, and
    whether its own was; which of the views that is, it has learned.
    """

    def __init__(self, views: int, width: int, *, cloud: int, coarse: int, fine: int, told: bool) -> None:
        """Take V, the channels of a query and of what it asks, and whether there is a view state."""
        super().__init__()
        self.view = nn.Parameter(torch.empty(views, width))
        self.whole = nn.Linear(cloud + (views + 1 if told else 0), width)
        self.inquiry = Inquiry(width, coarse=coarse, fine=fine)

    def forward(self, cloud: Tensor, coarse: Tensor, fine: Tensor, view_state: Tensor | None) -> Tensor:
        """Return what each view has learned."""
        known = cloud[:, None].expand(-1, len(self.view), -1)
        if view_state is not None:
            everywhere = view_state[:, None].expand(-1, len(self.view), -1)
            known = torch.cat((known, everywhere, view_state[..., None]), dim=-1)
        return torch.as_tensor(self.inquiry(self.view + self.whole(known), coarse, fine))


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
        self.key, self.value = nn.Linear(channels, width), nn.Linear(channels, width)
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

"""Neighbours within each cloud: the graph that edge convolutions run on. Rows of masked points are computed and mean nothing."""

import torch
from torch import Tensor


def nearest(features: Tensor, mask: Tensor, count: int) -> Tensor:
    """Return (B, N, k) rows of ``features.flatten(0, 1)``: the k nearest other points of each point, in no particular order.

    A cloud with too few points has some neighbours twice, which no maximum notices; a single point is its own neighbour.

    Args:
        features: (B, N, C) what nearness is judged by.
        mask: (B, N) which points are real; others are nobody's neighbours.
        count: k. A batch of clouds of N <= k points has N - 1 neighbours, at least 1.
    """
    batch, number, _ = features.shape
    own = torch.arange(number, device=features.device)
    with torch.no_grad():
        apart = _ordering(features.detach(), mask)
        apart = apart.masked_fill(~mask[:, None, :], torch.inf).masked_fill(own[:, None] == own, torch.inf)  # (B, N, N)
        distances, places = torch.topk(apart, max(min(count, number - 1), 1), largest=False)  # (B, N, k), nearest first
        first = torch.where(distances[..., :1] < torch.inf, places[..., :1], own[:, None])
        places = torch.where(distances < torch.inf, places, first)
        return places + number * torch.arange(batch, device=features.device)[:, None, None]


def _ordering(features: Tensor, mask: Tensor) -> Tensor:
    """Return (B, N, N) squared distances less a constant per row, which does not change who is nearest.

    They are taken about the mean: what is far from the origin would drown in rounding.
    """
    real = mask[..., None].to(features.dtype)
    about = (features - (features * real).sum(1, keepdim=True) / real.sum(1, keepdim=True)) * real
    squares = about.square().sum(-1)
    return squares[:, None, :] - 2 * about @ about.transpose(1, 2)


def gathered(features: Tensor, rows: Tensor) -> Tensor:
    """Return (B, N, k, C), the features (B, N, C) of the neighbours that :func:`nearest` names."""
    return torch.nn.functional.embedding(rows, features.flatten(0, 1))


def unrepeated(points: Tensor, mask: Tensor) -> Tensor:
    """Return (B, N) the mask without points that lie exactly where an earlier real one lies.

    A cloud that was filled up by repeating points then means the same as without: no neighbour and no attention counts twice.

    Args:
        points: (B, N, 3) points.
        mask: (B, N) which points are real.
    """
    x, y, z = points.unbind(-1)
    same = (x[:, :, None] == x[:, None]) & (y[:, :, None] == y[:, None]) & (z[:, :, None] == z[:, None])  # (B, N, N)
    place = torch.arange(points.shape[1], device=points.device)
    earlier = same & mask[:, None, :] & (place < place[:, None])
    return mask & ~earlier.any(-1)

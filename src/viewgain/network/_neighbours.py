"""Neighbours within each cloud: the graph that edge convolutions run on. Rows of masked points are computed and mean nothing."""

import torch
from torch import Tensor


def nearest(features: Tensor, mask: Tensor, count: int) -> Tensor:
    """Return (B, N, k) rows of ``features.flatten(0, 1)``: the k nearest other points of each point, in feature space.

    A cloud with too few points has some neighbours twice, which no maximum notices; a single point is its own neighbour.

    Args:
        features: (B, N, C) what nearness is judged by.
        mask: (B, N) which points are real; others are nobody's neighbours.
        count: k. Clouds of N <= k points have N - 1 neighbours, at least 1.
    """
    with torch.no_grad():
        real = mask[..., None].to(features.dtype)
        # About the mean: what is far from the origin would drown in rounding.
        about = features.detach() - (features * real).sum(1, keepdim=True) / real.sum(1, keepdim=True)
        squares = torch.where(mask, about.square().sum(-1), torch.inf)
        # The square of the row's own point would not change who is nearest.
        return _rows(squares[:, None, :] - 2 * about @ about.transpose(1, 2), count)


def nearest_in_space(points: Tensor, mask: Tensor, count: int) -> Tensor:
    """Return as :func:`nearest`, of (B, N, 3) points and with distances that are exact to the last bits.

    So two programs that run the same network seldom disagree about who is nearer.
    """
    with torch.no_grad():
        x, y, z = points.detach().unbind(-1)
        apart = (x[:, :, None] - x[:, None]).square() + (y[:, :, None] - y[:, None]).square()
        apart = apart + ((z[:, :, None] - z[:, None]).square() + torch.where(mask, 0.0, torch.inf)[:, None])
        return _rows(apart, count)


def _rows(apart: Tensor, count: int) -> Tensor:
    """Return the rows of the ``count`` least finite of (B, N, N) distances per point, itself left out."""
    batch, number, _ = apart.shape
    own = torch.arange(number, device=apart.device)
    apart = torch.where(own[:, None] == own, torch.inf, apart)
    distances, places = torch.topk(apart, max(min(count, number - 1), 1), largest=False)  # (B, N, k), nearest first
    first = torch.where(distances[..., :1] < torch.inf, places[..., :1], own[:, None])
    places = torch.where(distances < torch.inf, places, first)
    return places + number * torch.arange(batch, device=apart.device)[:, None, None]


def gathered(features: Tensor, rows: Tensor) -> Tensor:
    """Return (B, N, k, C), the features (B, N, C) of the neighbours that :func:`nearest` names."""
    return torch.nn.functional.embedding(rows, features.flatten(0, 1))


def highest(features: Tensor, rows: Tensor) -> Tensor:
    """Return (B, N, C), the maximum of each channel of (B, N, C) over the neighbours that :func:`nearest` names.

    Where a gradient is wanted, it flows to the one neighbour that has the maximum, straight to its row: less than half the time
    of the gradient of a maximum, which is as large as all edges.
    """
    if not (torch.is_grad_enabled() and features.requires_grad):
        return gathered(features, rows).amax(2)
    with torch.no_grad():
        winner = rows.gather(2, gathered(features, rows).max(2).indices)
    return features.flatten(0, 1).gather(0, winner.flatten(0, 1)).view_as(features)


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

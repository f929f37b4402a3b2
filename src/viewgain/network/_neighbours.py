"""Neighbours within each cloud: the graph that edge convolutions run on. Rows of masked points are computed and mean nothing."""

import torch
from torch import Tensor

LEAN = 1e-4
"""Of two neighbours at the same distance the one further along :data:`DIRECTION` counts as farther, by this share of the cloud's
mean squared feature and unit of length. Clouds from images or in half floats have many such ties; without it the program that
runs the network, and the order of the points, would decide them."""
DIRECTION = (0.61, 0.41, 0.73)
"""A direction that few grids of points lie across."""
ALONG = tuple(number + 1e-9 * root for number, root in zip(DIRECTION, (2**0.5, 3**0.5, 5**0.5), strict=True))
"""The same, a hair aside. Coordinates of images or half floats are whole numbers of some step, and along a direction of two
decimals points of such a grid lie exactly side by side; what sorts them would decide which comes first."""


def leaning(points: Tensor) -> Tensor:
    """Return (B, N) what decides between neighbours of (B, N, 3) points at the same distance, see :data:`LEAN`."""
    x, y, z = points.detach().unbind(-1)
    return LEAN * (DIRECTION[0] * x + DIRECTION[1] * y + DIRECTION[2] * z)


def nearest(features: Tensor, mask: Tensor, count: int, lean: Tensor) -> Tensor:
    """Return (B, N, k) rows of ``features.flatten(0, 1)``: the k nearest other points of each point, in feature space.

    A cloud with too few points has some neighbours twice, which no maximum notices; a single point is its own neighbour.

    Args:
        features: (B, N, C) what nearness is judged by.
        mask: (B, N) which points are real; others are nobody's neighbours.
        count: k. Clouds of N <= k points have N - 1 neighbours, at least 1.
        lean: (B, N) as :func:`leaning` returns it.
    """
    with torch.no_grad():
        real = mask[..., None].to(features.dtype)
        number = real.sum(1, keepdim=True)
        # About the mean and in double precision: rounding would decide between neighbours that are almost equally near, and
        # differs from program to program.
        about = ((features.detach() - (features * real).sum(1, keepdim=True) / number) * real).double()
        squares = about.square().sum(-1)
        leant = squares + lean * (squares.sum(1, keepdim=True) / number[..., 0])
        columns = torch.where(mask, leant, torch.inf)
        # The square of the row's own point would not change who is nearest.
        return _rows(columns[:, None, :] - 2 * about @ about.transpose(1, 2), count)


def in_order(points: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
    """Return (B, N, 3) points along :data:`ALONG`, the real ones first, and (B,) how many those are.

    Points at equal steps in this order are the same whatever order a cloud is given in, and as evenly spread as at random. It is
    found in double precision, so that two programs agree on it.

    Args:
        points: (B, N, 3) points.
        mask: (B, N) which are real.
    """
    with torch.no_grad():
        x, y, z = points.detach().double().unbind(-1)
        along = ALONG[0] * x + ALONG[1] * y + ALONG[2] * z
        order = torch.sort(torch.where(mask, along, torch.inf), dim=1).indices
    ordered = gathered(points, rows_of(order[..., None], points.shape[1]))[:, :, 0]
    return ordered, mask.sum(1)


def nearest_to(centres: Tensor, points: Tensor, number: Tensor, count: int) -> Tensor:
    """Return (B, M, k) rows of ``points.flatten(0, 1)``: the k points nearest to each centre, distances exact to the last bits.

    So two programs that run the same network hardly ever disagree about who is nearer. A cloud of too few points has the nearest
    one several times, which no maximum notices.

    Args:
        centres: (B, M, 3) places.
        points: (B, N, 3) points about one unit across, the real ones first.
        number: (B,) how many are real, at least 1.
        count: k.
    """
    with torch.no_grad():
        (a, b, c), (x, y, z) = centres.detach().unbind(-1), points.detach().unbind(-1)
        real = torch.arange(points.shape[1], device=points.device) < number[:, None]
        columns = torch.where(real, 0.1 * leaning(points), torch.inf)
        apart = (a[:, :, None] - x[:, None]).square() + (b[:, :, None] - y[:, None]).square()
        apart = apart + ((c[:, :, None] - z[:, None]).square() + columns[:, None])  # (B, M, N)
        distances, places = torch.topk(apart, min(count, points.shape[1]), largest=False)
        return rows_of(torch.where(distances < torch.inf, places, places[..., :1]), points.shape[1])


def rows_of(places: Tensor, number: int) -> Tensor:
    """Return, for (B, M, k) places within clouds of N points, the rows of those points when the clouds lie end to end."""
    return places + number * torch.arange(places.shape[0], device=places.device)[:, None, None]


def _rows(apart: Tensor, count: int) -> Tensor:
    """Return the rows of the ``count`` least finite of (B, N, N) distances per point, itself left out."""
    number = apart.shape[-1]
    own = torch.arange(number, device=apart.device)
    apart = torch.where(own[:, None] == own, torch.inf, apart)
    distances, places = torch.topk(apart, max(min(count, number - 1), 1), largest=False)  # (B, N, k), nearest first
    first = torch.where(distances[..., :1] < torch.inf, places[..., :1], own[:, None])
    places = torch.where(distances < torch.inf, places, first)
    return rows_of(places, number)


def gathered(features: Tensor, rows: Tensor) -> Tensor:
    """Return (B, M, k, C), the features (B, N, C) of the neighbours that :func:`nearest` or :func:`nearest_to` names."""
    return torch.nn.functional.embedding(rows, features.flatten(0, 1))


def highest(features: Tensor, rows: Tensor) -> Tensor:
    """Return (B, M, C), the maximum of each channel of (B, N, C) over the neighbours that :func:`nearest_to` names.

    Where a gradient is wanted, it flows to the one neighbour that has the maximum, straight to its row: less than half the time
    of the gradient of a maximum, which is as large as all edges.
    """
    if not (torch.is_grad_enabled() and features.requires_grad):
        return gathered(features, rows).amax(2)
    with torch.no_grad():
        winner = rows.gather(2, gathered(features, rows).max(2).indices)
    return features.flatten(0, 1).gather(0, winner.flatten(0, 1)).view(winner.shape)


def unrepeated(points: Tensor, mask: Tensor) -> Tensor:
    """Return (B, N) the mask without points that lie exactly where an earlier real one lies.

    A cloud that was filled up by repeating points then means the same as without: no neighbour and no attention counts twice.

    Args:
        points: (B, N, 3) points.
        mask: (B, N) which points are real.
    """
    order = torch.arange(points.shape[1], device=points.device).expand(mask.shape)
    # Stable sorts by one key after the other put equal points side by side, the earliest first, and those of the padding last.
    for key in (*points.detach().unbind(-1), ~mask):
        order = order.gather(1, torch.sort(key.gather(1, order), dim=1, stable=True).indices)
    ordered = gathered(points.detach(), rows_of(order[..., None], points.shape[1]))[:, :, 0]
    again = torch.zeros_like(mask)
    again[:, 1:] = (ordered[:, 1:] == ordered[:, :-1]).all(-1)
    return mask & ~torch.zeros_like(mask).scatter(1, order, again)

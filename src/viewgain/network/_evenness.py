"""From which view was a cloud seen? From the one in whose image its points lie evenly (ours).

A depth camera reads one range per pixel, so in its own image the points of a scan are spread evenly over all that it saw. In the
image of any other view, slanted sides are crowded, and what is near lies over what is far. That holds for every shape: how evenly
points lie needs no learning, only what it counts for does.
"""

import torch
from torch import Tensor

from viewgain.network._neighbours import gathered, rows_of

STATISTICS = ("mean spacing", "standard deviation", "mean deviation", "deviation of all")
"""What is said of each view."""
ASKED = 128
"""Points whose spacing is looked at."""
GROUPS = 8
"""The spacing of a point is the mean logarithm of how far the nearest point of each group is: smoother than the nearest of all,
and without sorting."""
_NEAREST, _FARTHEST = 2e-3, 1.0
"""Spacings count within these, in focal lengths: below the pitch of pixels they are rounding, and differ between programs."""
_IN_FRONT = 0.05


def evenness(points: Tensor, number: Tensor, stations: Tensor) -> Tensor:
    """Return (B, V, 4) how the points of clouds are spaced in the image of each view, less the mean over the views.

    Mean spacing; its standard deviation and its mean absolute deviation from point to point; and the standard deviation of all
    that it is the mean of. In the view of the scan the last three are the least.

    Args:
        points: (B, N, 3) points in the frame of the rig, the real ones first, none twice, in an order that mixes them
            (:func:`viewgain.network._neighbours.in_order`).
        number: (B,) how many are real, at least 1.
        stations: (V, 4, 4) camera to rig.
    """
    with torch.no_grad(), torch.autocast(points.device.type, enabled=False):
        each = spacings(images(points, number, stations), number)  # (B, V, A, G - 1)
        here = each.mean(-1)
        middle = here.mean(-1, keepdim=True)
        found = (
            middle[..., 0],
            _deviation(here),
            (here - middle).abs().mean(-1),
            _deviation(each.flatten(2)),
        )
        statistics = torch.stack(found, dim=-1)
        return statistics - statistics.mean(1, keepdim=True)


def images(points: Tensor, number: Tensor, stations: Tensor) -> Tensor:
    """Return (B, V, N, 2) where points lie in the images of views, in focal lengths from the middle of the real ones."""
    seen = (points[:, None] - stations[:, None, :3, 3]) @ stations[:, :3, :3]
    image = seen[..., :2] / seen[..., 2:].clamp(min=_IN_FRONT)
    real = torch.arange(points.shape[1], device=points.device) < number[:, None]
    # About their middle, so that the squares below lose no digits.
    return image - (image * real[:, None, :, None]).sum(2, keepdim=True) / number[:, None, None, None]


def spacings(image: Tensor, number: Tensor) -> Tensor:
    """Return (B, V, A, G - 1) logarithms: how far from some points the nearest one of every other group is.

    Args:
        image: (B, V, N, 2) places in an image; point n is of group n modulo G.
        number: (B,) how many are real; those asked are at equal steps among them.
    """
    image = torch.nn.functional.pad(image, (0, 0, 0, -image.shape[2] % GROUPS))
    batch, views, count, _ = image.shape
    real = torch.arange(count, device=image.device) < number[:, None]
    asked = (torch.arange(ASKED, device=image.device) * number[:, None]) // ASKED  # (B, A)
    own = gathered(image.transpose(1, 2).flatten(2), rows_of(asked[..., None], count)).reshape(batch, ASKED, views, 2)
    own, squares = own.transpose(1, 2), torch.where(real[:, None], image.square().sum(-1), torch.inf)
    # |a - b|^2 = |a|^2 - 2 a b + |b|^2, all in one product of matrices.
    left = torch.cat((own, own.square().sum(-1, keepdim=True), torch.ones_like(own[..., :1])), dim=-1)
    right = torch.cat((-2 * image, torch.ones_like(squares[..., None]), squares[..., None]), dim=-1)
    # Those of a group side by side: a minimum over neighbours in memory takes a tenth of the time.
    by_group = right.reshape(batch, views, -1, GROUPS, 4).transpose(2, 3).flatten(2, 3)
    nearest = (left @ by_group.transpose(2, 3)).reshape(batch, views, ASKED, GROUPS, -1).amin(-1)
    # A point is in its own group, at no distance: the groups after it are the others.
    others = (asked[..., None] + torch.arange(1, GROUPS, device=image.device)) % GROUPS  # (B, A, G - 1)
    found = nearest.gather(3, others[:, None].expand(-1, views, -1, -1))
    return torch.as_tensor(found.clamp(_NEAREST**2, _FARTHEST**2).log() / 2)


def _deviation(values: Tensor) -> Tensor:
    """Return the standard deviation along the last axis."""
    return (values - values.mean(-1, keepdim=True)).square().mean(-1).sqrt()

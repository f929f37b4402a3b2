"""A cloud at three sizes: points, many centres, few centres (PointNet++, Qi et al. 2017). All networks of ours begin with it."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from viewgain.network._abstraction import SetAbstraction
from viewgain.network._neighbours import in_order
from viewgain.network._settings import NetworkSettings


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Levels:
    """The points, both sets of centres, where they are and what they know of their surroundings, and the mean of all points."""

    points: Tensor
    """(B, N, 3) the real ones first, in an order that mixes them."""
    number: Tensor
    """(B,) how many are real."""
    mean: Tensor
    """(B, width) of the points' own features: how densely each side is sampled, which maxima do not tell."""
    fine_points: Tensor
    """(B, M, 3)."""
    fine: Tensor
    """(B, M, 4 width)."""
    coarse_points: Tensor
    """(B, L, 3)."""
    coarse: Tensor
    """(B, L, 8 width)."""

    @property
    def near(self) -> Tensor:
        """(B, M, 4 width + 3) the fine centres with their places."""
        return torch.cat((self.fine, self.fine_points), dim=-1)

    @property
    def far(self) -> Tensor:
        """(B, L, 8 width + 3) the coarse ones."""
        return torch.cat((self.coarse, self.coarse_points), dim=-1)


class Hierarchy(nn.Module):
    """Points (B, N, 3) and a mask (B, N) to :class:`Levels`; the order of the points means nothing."""

    def __init__(self, settings: NetworkSettings) -> None:
        """Take width, centres and neighbours from the settings."""
        super().__init__()
        width, (many, few) = settings.width, settings.centres
        self.lift = nn.Sequential(nn.Linear(3, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.fine = SetAbstraction(width, 2 * width, 4 * width, centres=many, neighbours=settings.neighbours)
        self.coarse = SetAbstraction(4 * width, 4 * width, 8 * width, centres=few, neighbours=settings.neighbours)

    def forward(self, points: Tensor, mask: Tensor) -> Levels:
        """Return both levels."""
        points, number = in_order(points, mask)
        lifted = self.lift(points)
        real = torch.arange(points.shape[1], device=points.device) < number[:, None]
        mean = (lifted * real[..., None]).sum(1) / number[:, None]
        fine_points, fine = self.fine(points, lifted, number)
        coarse_points, coarse = self.coarse(fine_points, fine, torch.full_like(number, fine.shape[1]))
        return Levels(
            points=points,
            number=number,
            mean=mean,
            fine_points=fine_points,
            fine=fine,
            coarse_points=coarse_points,
            coarse=coarse,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Impression:
    """What is known of a cloud before any view of a rig is asked about."""

    levels: Levels
    """Its points, taken together."""
    whole: Tensor
    """(B, 8 width) one feature."""
    seen: Tensor | None
    """(B, V, 4 width) what each view sees of it from where it stands; None if views do not look."""
    even: Tensor | None
    """(B, V, 4) how evenly its points lie in the image of each view; None if nobody asks, or no view knows where it stands."""

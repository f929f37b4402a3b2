"""Set abstraction: a cloud taken together to fewer points that each know their surroundings.

A layer on edges followed by a maximum, max_j (A x_i + B x_j), is A x_i + max_j B x_j, so B x is computed per point and only its
maximum is taken along edges; with the points' places among the features, that covers W (x_j, p_j - p_i).
"""

import torch
from torch import Tensor, nn

from viewgain.network._neighbours import gathered, highest, nearest_to, rows_of


class SetAbstraction(nn.Module):
    """Centres of a cloud, each with a layer on the maximum over its neighbours.

    Shapes: places (B, N, 3), features (B, N, C) and numbers (B,) to (B, M, 3) and (B, M, out).

    Source: PointNet++ (Qi et al. 2017). Differs: one layer on edges, and centres at equal steps in the order of the points
    instead of always the farthest.
    """

    def __init__(self, channels: int, between: int, outputs: int, *, centres: int, neighbours: int) -> None:
        """Take the channels of a point before, on edges and after, M, and k."""
        super().__init__()
        self.centres, self.neighbours = centres, neighbours
        self.own = nn.Linear(channels + 3, between)
        self.other = nn.Linear(channels + 3, between, bias=False)
        self.after = nn.Linear(between, outputs)

    def forward(self, places: Tensor, features: Tensor, number: Tensor) -> tuple[Tensor, Tensor]:
        """Return centres and their features; a cloud of fewer than M points has some centres several times.

        Args:
            places: (B, N, 3) the real points first (:func:`in_order`).
            features: (B, N, C) theirs.
            number: (B,) how many are real, at least 1.
        """
        joined = torch.cat((features, places), dim=-1)
        chosen = (torch.arange(self.centres, device=places.device) * number[:, None]) // self.centres  # (B, M)
        own = gathered(joined, rows_of(chosen[..., None], places.shape[1]))[:, :, 0]
        centres = own[..., -3:]
        near = nearest_to(centres, places, number, self.neighbours)
        mixed = torch.relu(self.own(own) + highest(self.other(joined), near))
        return centres, torch.relu(self.after(mixed))

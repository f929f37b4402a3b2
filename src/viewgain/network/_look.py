"""What each candidate view sees of the points: a candidate looks at them from where it stands (ours)."""

import torch
from torch import Tensor, nn


class Look(nn.Module):
    """The maximum over the points of a layer on what a point is and where it stands for a view.

    Shapes: features (B, M, C), places (B, V, M, P) to (B, V, out). One set of weights serves all views, so what one view has
    learned of a shape that lies before it, all have.
    """

    def __init__(self, channels: int, numbers: int, between: int, outputs: int) -> None:
        """Take C, P, the channels that are kept of each point, and those of the result."""
        super().__init__()
        self.what = nn.Linear(channels, between)
        self.where = nn.Sequential(nn.Linear(numbers, between), nn.ReLU(), nn.Linear(between, between, bias=False))
        self.after = nn.Linear(between, outputs)

    def forward(self, features: Tensor, places: Tensor) -> Tensor:
        """Return what each view sees."""
        each = torch.relu(self.what(features)[:, None] + self.where(places))
        return torch.as_tensor(self.after(each.amax(2)))

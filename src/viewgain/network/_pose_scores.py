"""Scores of any candidates of any rig: what is given of each is its pose relative to the present camera (ours).

The cloud is taken together as in the compact networks. Every candidate then asks its points; and it looks at them: their places
in the candidate's own camera say what would lie in its image, from how far away and how near to the border.
"""

import torch
from torch import Tensor, nn

from viewgain.errors import ConfigError
from viewgain.network._hierarchy import Hierarchy
from viewgain.network._inputs import ScoreNetwork
from viewgain.network._look import Look
from viewgain.network._output import NUMBERS, answers_as_output
from viewgain.network._queries import Inquiry
from viewgain.network._settings import NetworkSettings

NUMBERS_OF_A_POSE = 12
"""Rotation, row by row, and position."""
NUMBERS_OF_A_PLACE = 5
"""Of :func:`placed`."""


class PoseScores(ScoreNetwork):
    """A cloud and poses (B, V, 4, 4) of candidates in the cloud's camera, to a score for each; V is any number.

    The score of a candidate does not depend on the others, so their order carries the scores along, and masks are not needed.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the settings; the parameters are set by :func:`viewgain.network.build`."""
        super().__init__(settings)
        width = settings.width
        self.hierarchy = Hierarchy(settings)
        self.wide = nn.Linear(8 * width + 3, 8 * width)
        self.pose = nn.Sequential(nn.Linear(NUMBERS_OF_A_POSE, 4 * width), nn.ReLU(), nn.Linear(4 * width, 4 * width))
        self.whole = nn.Linear(8 * width, 4 * width)
        self.look = Look(4 * width, NUMBERS_OF_A_PLACE, 2 * width, 4 * width)
        self.inquiry = Inquiry(4 * width, coarse=8 * width + 3, fine=4 * width + 3)
        self.head = nn.Sequential(nn.Linear(4 * width, 4 * width), nn.ReLU(), nn.Linear(4 * width, NUMBERS[settings.uncertainty]))

    def scored(self, points: Tensor, mask: Tensor, told: Tensor | None) -> Tensor:
        """Return the scores (B, V), with uncertainty (B, V, 2) or (B, V, 4)."""
        assert told is not None  # the check of inputs has made sure of it
        levels = self.hierarchy(points, mask)
        cloud = torch.relu(self.wide(levels.far)).amax(1)
        turns, places = told[..., :3, :3], told[..., :3, 3]
        views = self.pose(torch.cat((turns.flatten(2), places), dim=-1)) + self.whole(cloud)[:, None]
        seen = (levels.fine_points[:, None] - places[:, :, None]) @ turns  # (B, V, M, 3) in each candidate's camera
        views = views + self.look(levels.fine, placed(seen))
        answers = self.head(self.inquiry(views, levels.far, levels.near))
        return answers_as_output(answers)

    def _check(self, told: Tensor | None, batch: int) -> None:
        if told is None or told.ndim != 4 or told.shape[0] != batch or told.shape[2:] != (4, 4):
            got = "none" if told is None else str(tuple(told.shape))
            raise ConfigError(f"network {self.settings.kind}: got poses {got}, wanted ({batch}, candidates, 4, 4)")


def placed(seen: Tensor) -> Tensor:
    """Return (..., 5) where points (..., 3) of a camera's frame stand: in space, and in its image.

    There it is x / z and y / z, with z kept over 5 cm and both within 3.
    """
    image = (seen[..., :2] / seen[..., 2:].clamp(min=0.05)).clamp(-3.0, 3.0)
    return torch.cat((seen, image), dim=-1)

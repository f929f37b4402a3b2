"""The compact networks: the same question and answer as PC-NBV at a fraction of its time (ours).

What PC-NBV spends its time on is 1024 x 1024 numbers per point, attention between all points, and four searches for neighbours
in feature space. Here the cloud is taken together twice (PointNet++, Qi et al. 2017), to 64 and to 16 points that each know
their surroundings, and then every candidate view asks those points what it would see.
"""

import torch
from torch import Tensor, nn

from viewgain.network._hierarchy import Hierarchy
from viewgain.network._inputs import ScoreNetwork
from viewgain.network._neighbours import unrepeated
from viewgain.network._output import NUMBERS, answers_as_output
from viewgain.network._queries import ViewQueries
from viewgain.network._settings import NetworkSettings


class Compact(ScoreNetwork):
    """Points, many centres, few centres, one feature of the cloud; then a query per view, and its scores."""

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the settings; the parameters are set by :func:`viewgain.network.build`."""
        super().__init__(settings)
        width, views, told = settings.width, settings.views, settings.with_view_state
        self.hierarchy = Hierarchy(settings)
        self.wide = nn.Linear(8 * width + 3, 16 * width)
        self.cloud = nn.Linear(16 * width, 8 * width)
        self.queries = ViewQueries(views, 4 * width, cloud=8 * width, coarse=8 * width + 3, fine=4 * width + 3, told=told)
        self.each = NUMBERS[settings.uncertainty]
        self.head = nn.Sequential(
            nn.Linear(4 * width, 8 * width), nn.ReLU(), nn.Linear(8 * width, self.each + (0 if told else 1))
        )

    def scored(self, points: Tensor, mask: Tensor, view_state: Tensor | None) -> Tensor:
        """Return the scores."""
        if view_state is None:
            return self._located(points, mask)[0]
        return answers_as_output(self._answers(points, mask, view_state))

    def located(self, points: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """Return the scores with the present view first, and (B, V) logits of the present view being each of the rig's."""
        return super().located(points, mask) if self.settings.with_view_state else self._located(points, unrepeated(points, mask))

    def _located(self, points: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        answers = self._answers(points, mask, None)
        presence = answers[..., self.each]
        rolled = mean_present_first(answers[..., : self.each], presence)
        # The shape in plain numbers, so that an exported file states it.
        return answers_as_output(rolled.reshape(-1, self.settings.views, self.each)), presence

    def _answers(self, points: Tensor, mask: Tensor, view_state: Tensor | None) -> Tensor:
        """Return (B, V, each) what the head says of each view; without the view state one more, the logit of its presence."""
        levels = self.hierarchy(points, mask)
        cloud = torch.relu(self.cloud(torch.relu(self.wide(levels.far).amax(1))))
        return torch.as_tensor(self.head(self.queries(cloud, levels.far, levels.near, view_state)))


def mean_present_first(answers: Tensor, presence: Tensor) -> Tensor:
    """Return (B, V, c) answers in rig order with the present view first, which is not known: it is each view with some chance.

    The chances are the softmax of ``presence`` (B, V), and what is returned is the mean of the rolled answers under them. In the
    object's frame a partial cloud tells from where it was seen, so one view gets nearly all of it.
    """
    views = torch.arange(answers.shape[1], device=answers.device)
    rolled = answers[:, (views[:, None] + views) % len(views)]  # (B, V, V, c): row v as if v were the present view
    return (torch.softmax(presence, dim=-1)[..., None, None] * rolled).sum(1)

"""The compact networks: the same question and answer as PC-NBV at a fraction of its time (ours).

What PC-NBV spends its time on is 1024 x 1024 numbers per point, attention between all points, and four searches for neighbours
in feature space. Here the cloud is taken together twice (PointNet++, Qi et al. 2017), to 64 and to 16 points that each know
their surroundings, and then every candidate view asks those points what it would see.
"""

import numpy as np
import torch
from torch import Tensor, nn

from viewgain.arrays import Poses
from viewgain.network._evenness import evenness
from viewgain.network._hierarchy import Hierarchy, Impression
from viewgain.network._inputs import ScoreNetwork
from viewgain.network._look import Look
from viewgain.network._neighbours import unrepeated
from viewgain.network._output import NUMBERS, answers_as_output
from viewgain.network._queries import Guess, ViewQueries
from viewgain.network._settings import NetworkSettings
from viewgain.rigs import Target, poses, rig


class Compact(ScoreNetwork):
    """Points, many centres, few centres, one feature of the cloud; then a query per view, and its scores.

    Without the view state a first round of queries guesses from which view the cloud was seen, and the second answers as if it
    had been told. Where views know their places, the guess also goes by the view in whose image the points lie evenly.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        """Take the settings; the parameters are set by :func:`viewgain.network.build`."""
        super().__init__(settings)
        width, views, blind = settings.width, settings.views, not settings.with_view_state
        self.hierarchy = Hierarchy(settings)
        self.wide = nn.Linear(8 * width + 3, 16 * width)
        self.cloud = nn.Linear(17 * width, 8 * width)
        self.stations = stations_of(settings.rig) if settings.rig else None
        self.look = Look(4 * width, 3, 2 * width, 4 * width) if settings.rig else None
        self.guess = Guess(views, width, placed=bool(settings.rig)) if blind else None
        self.queries = ViewQueries(views, width, told=True)
        self.head = nn.Sequential(nn.Linear(4 * width, 8 * width), nn.ReLU(), nn.Linear(8 * width, NUMBERS[settings.uncertainty]))

    def scored(self, points: Tensor, mask: Tensor, view_state: Tensor | None) -> Tensor:
        """Return the scores."""
        if view_state is None:
            return self._located(points, mask)[0]
        return answers_as_output(self._answers(self._impression(points, mask), view_state))

    def located(self, points: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """Return the scores with the present view first, and (B, V) logits of the present view being each of the rig's."""
        return super().located(points, mask) if self.settings.with_view_state else self._located(points, unrepeated(points, mask))

    def _located(self, points: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        assert self.guess is not None  # it is there without the view state
        cloud = self._impression(points, mask)
        presence = self.guess(cloud)
        answers = mean_present_first(self._answers(cloud, torch.softmax(presence, dim=-1)), presence)
        # The shape in plain numbers, so that an exported file states it.
        return answers_as_output(answers.reshape(-1, self.settings.views, NUMBERS[self.settings.uncertainty])), presence

    def _impression(self, points: Tensor, mask: Tensor) -> Impression:
        levels = self.hierarchy(self.standardised(points), mask)
        greatest = torch.relu(self.wide(levels.far).amax(1))
        whole = torch.relu(self.cloud(torch.cat((greatest, levels.mean), dim=-1)))
        if self.look is None:
            return Impression(levels=levels, whole=whole, seen=None, even=None)
        stations = torch.as_tensor(self.stations, dtype=points.dtype, device=points.device)
        seen = self.look(levels.fine, levels.fine_points[:, None] @ stations[:, :3, :3])
        even = None if self.guess is None else evenness(levels.points, levels.number, stations)
        return Impression(levels=levels, whole=whole, seen=seen, even=even)

    def _answers(self, cloud: Impression, view_state: Tensor) -> Tensor:
        """Return (B, V, c) what the head says of each view, in rig order."""
        return torch.as_tensor(self.head(self.queries(cloud, view_state)))


def stations_of(name: str) -> Poses:
    """Return (V, 4, 4) the views of a rig in the object's frame, one diagonal of the object away where the rig says nothing."""
    return poses(rig(name), Target.at(np.zeros(3)), distance=1.0)


def mean_present_first(answers: Tensor, presence: Tensor) -> Tensor:
    """Return (B, V, c) answers in rig order with the present view first, which is not known: it is each view with some chance.

    The chances are the softmax of ``presence`` (B, V), and what is returned is the mean of the rolled answers under them. In the
    object's frame a partial cloud tells from where it was seen, so one view gets nearly all of it.
    """
    views = torch.arange(answers.shape[1], device=answers.device)
    rolled = answers[:, (views[:, None] + views) % len(views)]  # (B, V, V, c): row v as if v were the present view
    return (torch.softmax(presence, dim=-1)[..., None, None] * rolled).sum(1)

"""A policy that cannot say anything about a box: the camera leaves for the farthest position it can reach."""

import numpy as np

from viewgain.evaluation import VolumeSettings, volume_case
from viewgain.evaluation._choice import choice
from viewgain.plan import Seen


class Silent:
    """Never knows."""

    name = "silent"

    def scores(self, seen: Seen) -> np.ndarray:
        return np.full(len(seen.candidates), np.nan)


def test_without_an_opinion_the_farthest_position_in_reach_is_taken() -> None:
    settings = VolumeSettings(seed=5, rig="irregular4")
    out_of_reach = 0
    for number in range(12):
        case = volume_case(settings, number)
        said = choice(case, Silent())
        away = np.linalg.norm(case.stations[:, :3, 3] - case.stations[case.present, :3, 3], axis=1)
        assert (said.has_opinion, said.margin) == (False, 0.0)
        assert case.reachable[said.position]
        assert away[said.position] == away[case.reachable].max()
        out_of_reach += not case.reachable.all()
    assert out_of_reach > 0

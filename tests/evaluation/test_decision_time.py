"""What a decision is said to take does not depend on who decided before: nobody finds the predictions of another."""

import numpy as np

from viewgain.evaluation import VolumeSettings, volume_case
from viewgain.evaluation._choice import decisions
from viewgain.geometry import inverse
from viewgain.plan import Seen, forget_predictions, predict
from viewgain.plan._predict import _predicted


def test_nobody_finds_the_predictions_of_another() -> None:
    case = volume_case(VolumeSettings(seed=5, rig="irregular4"), 0)
    found: list[int] = []

    class Predicting:
        name = "predicting"

        def scores(self, seen: Seen) -> np.ndarray:
            box = case.box.in_frame(inverse(seen.candidates[0]))
            predict(box, np.eye(4), case.camera, 1.0)
            predict(box, np.eye(4), case.camera, 1.0)
            found.append(_predicted.cache_info().hits)
            return np.arange(len(seen.candidates), dtype=float)

    choices, spent = decisions(case, ["one", "other"], lambda name, case: Predicting())
    assert found == [1, 1]  # its own, the second time
    assert list(choices) == list(spent) == ["one", "other"]
    forget_predictions()
    assert _predicted.cache_info().currsize == 0

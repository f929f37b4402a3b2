"""The learned part of the expected error: it moves a guess as far as it may, and comes back from its file as it was."""

import json
from pathlib import Path

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.errors import ModelError
from viewgain.plan import MOST_SHIFT, ErrorModel, _error_model, circumstances, log_odds, showing
from viewgain.plan._error_model import error_model_from, shipped_error_model
from viewgain.scenes import orbit_pose, standing_box


def model(last: float, inputs: int = 3) -> ErrorModel:
    rng = np.random.default_rng(1)
    hidden = (rng.normal(size=(4, inputs)), rng.normal(size=4))
    return ErrorModel(np.zeros(inputs), np.ones(inputs), (hidden, (np.zeros((1, 4)), np.array([last]))))


@pytest.mark.parametrize("guess", [0.0, 1e-3, 0.2, 0.5, 0.97, 1.0])
def test_without_a_shift_the_guess_stays(guess: float) -> None:
    assert model(0.0).corrected(guess, np.ones(2)) == pytest.approx(np.clip(guess, 1e-4, 1 - 1e-4), abs=1e-12)


def test_the_shift_is_bounded_and_goes_its_way() -> None:
    far = log_odds(model(1e9).corrected(0.3, np.ones(2))) - log_odds(0.3)
    assert far == pytest.approx(MOST_SHIFT, abs=1e-6)
    said = [model(last).corrected(0.3, np.ones(2)) for last in (-5.0, -1.0, 0.0, 1.0, 5.0)]
    assert said == sorted(said)


def test_circumstances_far_from_all_that_was_learned_count_as_the_border() -> None:
    rng = np.random.default_rng(2)
    net = ErrorModel(np.zeros(3), np.ones(3), ((rng.normal(size=(1, 3)), np.zeros(1)),))
    assert net.corrected(0.3, np.array([3.0, -3.0])) == net.corrected(0.3, np.array([1e9, -1e9]))
    assert net.corrected(0.3, np.array([2.0, -3.0])) != net.corrected(0.3, np.array([3.0, -3.0]))


def test_it_comes_back_from_json() -> None:
    again = error_model_from(json.loads(json.dumps(model(0.7).to_dict())))
    assert again.corrected(0.2, np.array([0.3, -1.0])) == model(0.7).corrected(0.2, np.array([0.3, -1.0]))


def test_the_shipped_one_fits_the_circumstances() -> None:
    box = standing_box(np.array([0.3, 0.2, 0.1]))
    camera = sensor("pico_flexx")
    seen = showing(box, orbit_pose(box.centre, 0.5, 0.6, 1.2), camera, 1.0)
    numbers = circumstances(box, seen.knowledge, (seen,), camera)
    shipped = shipped_error_model()
    assert len(shipped.mean) == len(shipped.scale) == len(numbers) + 1
    assert np.all(np.isfinite(numbers))
    assert np.all(shipped.scale > 0)


def test_a_broken_file_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for content in ("", "{}", '{"mean": [1], "scale": [1], "layers": [3]}'):
        file = tmp_path / "model.json"
        file.write_text(content)
        monkeypatch.setattr(_error_model, "FILE", file)
        shipped_error_model.cache_clear()
        with pytest.raises(ModelError, match="broken"):
            shipped_error_model()
    monkeypatch.undo()
    shipped_error_model.cache_clear()

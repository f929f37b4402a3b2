"""The learned part of the expected error: it moves a guess as far as it may, and comes back from its file as it was."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.perceptron import corrected_slowly
from viewgain.camera import sensor
from viewgain.errors import ModelError
from viewgain.plan import MOST_SHIFT, ErrorModel, Outcome, _error_model, circumstances, showing, transformed
from viewgain.plan._error_model import error_model_from, shipped_error_model
from viewgain.scenes import orbit_pose, standing_box

GUESS = Outcome(0.3, 0.02)


def model(odds: float, size: float, members: int = 2) -> ErrorModel:
    """Two perceptrons on two circumstances that always shift by so much."""
    rng = np.random.default_rng(1)
    hidden = (rng.normal(size=(members, 5, 4)), rng.normal(size=(members, 5)))
    return ErrorModel(np.zeros(4), np.ones(4), (hidden, (np.zeros((members, 2, 5)), np.tile([odds, size], (members, 1)))))


def drawn(seed: int) -> ErrorModel:
    rng = np.random.default_rng(seed)
    layers = tuple((rng.normal(size=(3, *shape)), rng.normal(size=(3, shape[0]))) for shape in ((6, 4), (5, 6), (2, 5)))
    return ErrorModel(rng.normal(size=4), rng.uniform(0.5, 2, 4), layers)


@pytest.mark.parametrize("missed", [0.0, 1e-3, 0.5, 0.97, 1.0])
@pytest.mark.parametrize("off", [0.0, 1e-3, 0.2, 1.0])
def test_without_a_shift_the_guess_stays(missed: float, off: float) -> None:
    said = model(0.0, 0.0).corrected(Outcome(missed, off), np.ones(2))
    assert said.missed == pytest.approx(np.clip(missed, 1e-4, 1 - 1e-4), abs=1e-12)
    assert said.off == pytest.approx(max(off, 1e-4), rel=1e-12)


def test_shifts_are_bounded_and_go_their_way() -> None:
    low, high = (model(by, by).corrected(GUESS, np.ones(2)) for by in (-1e9, 1e9))
    assert transformed(high)[0] - transformed(GUESS)[0] == pytest.approx(MOST_SHIFT, abs=1e-6)
    assert transformed(GUESS)[1] - transformed(low)[1] == pytest.approx(MOST_SHIFT, abs=1e-6)
    assert high.off == 1.0  # and no more
    said = [model(by, by).corrected(GUESS, np.ones(2)) for by in (-5.0, -1.0, 0.0, 1.0, 2.0)]
    for values in ([each.missed for each in said], [each.off for each in said], [each.expected for each in said]):
        assert values == sorted(set(values))


@given(missed=st.floats(0, 1), off=st.floats(0, 1))
def test_expected_is_a_mean_of_a_miss_and_of_how_far_off_volumes_are(missed: float, off: float) -> None:
    expected = Outcome(missed, off).expected
    assert max(missed, off) - 1e-12 <= expected <= 1 + 1e-12
    assert Outcome(0.0, off).expected == off
    assert Outcome(1.0, off).expected == 1


@given(seed=st.integers(0, 50), missed=st.floats(0, 1), off=st.floats(0, 1), number=st.floats(-5, 5))
def test_it_agrees_with_a_slow_twin(seed: int, missed: float, off: float, number: float) -> None:
    guess, circumstance = Outcome(missed, off), np.array([number, 1 - number])
    said = drawn(seed).corrected(guess, circumstance)
    assert (said.missed, said.off) == pytest.approx(corrected_slowly(drawn(seed), guess, circumstance), rel=1e-9)


def test_circumstances_far_from_all_that_was_learned_count_as_the_border() -> None:
    rng = np.random.default_rng(2)
    net = ErrorModel(np.zeros(4), np.ones(4), ((rng.normal(size=(1, 2, 4)), np.zeros((1, 2))),))
    assert net.corrected(GUESS, np.array([3.0, -3.0])) == net.corrected(GUESS, np.array([1e9, -1e9]))
    assert net.corrected(GUESS, np.array([2.0, -3.0])) != net.corrected(GUESS, np.array([3.0, -3.0]))


def test_it_comes_back_from_json() -> None:
    again = error_model_from(json.loads(json.dumps(drawn(3).to_dict())))
    assert again.corrected(GUESS, np.array([0.3, -1.0])) == drawn(3).corrected(GUESS, np.array([0.3, -1.0]))


def test_the_shipped_one_fits_the_circumstances() -> None:
    box = standing_box(np.array([0.3, 0.2, 0.1]))
    camera = sensor("pico_flexx")
    seen = showing(box, orbit_pose(box.centre, 0.5, 0.6, 1.2), camera, 1.0)
    numbers = circumstances(box, seen.knowledge, (seen,), camera)
    shipped = shipped_error_model()
    assert len(shipped.mean) == len(shipped.scale) == len(numbers) + 2
    assert np.all(np.isfinite(numbers))
    assert np.all(shipped.scale > 0)


def test_of_two_views_the_one_counts_that_shows_more_floor_and_the_one_that_the_box_fits_better() -> None:
    box, camera = standing_box(np.array([0.6, 0.4, 0.3])), sensor("pico_flexx")
    near, far = (showing(box, orbit_pose(box.centre, 0.5, 0.6, distance), camera, 1.0) for distance in (0.8, 1.6))
    assert near.floor.share < far.floor.share
    assert near.clearance < far.clearance
    known = near.knowledge.plus(far.knowledge)
    both, alone = circumstances(box, known, (near, far), camera)[-3:], circumstances(box, known, (far,), camera)[-3:]
    returns = np.log(max(near.floor.returns, far.floor.returns))
    assert both == pytest.approx([returns, np.log(far.floor.share), far.clearance])
    assert both[1:] == pytest.approx(alone[1:])


def test_a_broken_file_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for content in ("", "{}", '{"mean": [1], "scale": [1], "layers": [3]}', '{"mean": [1], "scale": [1], "layers": []}'):
        file = tmp_path / "model.json"
        file.write_text(content)
        monkeypatch.setattr(_error_model, "FILE", file)
        shipped_error_model.cache_clear()
        with pytest.raises(ModelError, match="broken"):
            shipped_error_model()
    monkeypatch.undo()
    shipped_error_model.cache_clear()

"""Scale divisions, rounding up and dimensional weight, by hand."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.errors import ConfigError
from viewgain.parcels import Rules, billed


def test_a_parcel_by_hand() -> None:
    out = billed((0.4037, 0.3012, 0.1988), Rules(division=0.005, round_up=0.01, divisor=5000))
    np.testing.assert_allclose(out.dimensions, [0.41, 0.30, 0.20])  # 0.405 is rounded up, 0.30 and 0.20 stay
    assert out.dimensional_weight == pytest.approx(41 * 30 * 20 / 5000)
    assert not out.too_small


def test_under_twelve_divisions_is_marked_by_what_was_measured() -> None:
    assert billed((0.5, 0.3, 0.0599), Rules(division=0.005)).too_small
    assert not billed((0.5, 0.3, 0.06), Rules(division=0.005)).too_small
    assert not billed((0.5, 0.3, 0.01), Rules()).too_small


def test_nothing_asked_nothing_done() -> None:
    out = billed((0.4037, 0.3012, 0.1988), Rules())
    assert out.dimensions == (0.4037, 0.3012, 0.1988)
    assert out.dimensional_weight is None
    json.dumps(out.to_dict())


@given(st.lists(st.floats(0, 3), min_size=3, max_size=3), st.floats(0.001, 0.1))
def test_rounding_moves_by_half_a_division_and_rounding_up_never_lowers(dimensions: list[float], unit: float) -> None:
    near, up = billed(dimensions, Rules(division=unit)).dimensions, billed(dimensions, Rules(round_up=unit)).dimensions
    assert np.all(np.abs(np.array(near) - dimensions) <= unit * 0.5000001)
    assert np.all(np.array(up) >= np.array(dimensions) - 2e-6 * unit)
    assert np.all(np.array(up) < np.array(dimensions) + unit * 1.000001)


@pytest.mark.parametrize("bad", [{"division": 0.0}, {"round_up": -1.0}, {"divisor": float("nan")}])
def test_rules_without_sense_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match="wanted a positive number"):
        Rules(**bad)


def test_dimensions_without_sense_are_refused() -> None:
    with pytest.raises(ConfigError, match="three lengths"):
        billed((1.0, float("inf"), 1.0), Rules())

"""The switches: every name works, every unknown one is refused with the list, and each switch does something by itself."""

from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.scenes import corner_view
from tests.simulate.targets import FAR, PICO, Array
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.scenes import Scene, standing_box
from viewgain.simulate import EFFECTS, Effects, capture

BUSY = replace(
    PICO,
    intrinsics=Intrinsics.from_field_of_view(60, 46, *np.deg2rad([62.0, 45.0])),
    jitter_px=0.5,
    lateral_px=0.6,
    flying_filter=0.03,
    unambiguous=1.2,
    step=0.002,
    grazing_start=np.deg2rad(40),
    grazing_end=np.deg2rad(75),
)
"""A camera with something of everything."""


def image(effects: Effects) -> Array:
    box = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)
    return capture(Scene((box,)), corner_view(box), BUSY, rng=np.random.default_rng(3), effects=effects).organised()


def test_all_are_on_by_default_and_only_takes_all_off() -> None:
    assert Effects() == Effects.only(*EFFECTS)
    assert Effects.only() == Effects().without(*EFFECTS)
    assert not any(getattr(Effects.only(), name) for name in EFFECTS)
    assert all(getattr(Effects(), name) for name in EFFECTS)
    assert tuple(field.name for field in fields(Effects)) == EFFECTS
    assert len(EFFECTS) == 10


@given(st.sets(st.sampled_from(EFFECTS)))
def test_only_some_is_all_without_the_others(names: set[str]) -> None:
    some = Effects.only(*names)
    assert some == Effects().without(*(set(EFFECTS) - names))
    assert {name for name in EFFECTS if getattr(some, name)} == names
    assert some.without(*names) == Effects.only()
    assert some.without() == some


@pytest.mark.parametrize("names", [("nose",), ("noise", "nose"), ("",), ("Noise",)])
def test_unknown_names_are_refused_with_the_list(names: tuple[str, ...]) -> None:
    unknown = repr(names[-1])
    for call in (Effects.only, Effects().without):
        with pytest.raises(ConfigError, match=f"effect {unknown} is not known") as raised:
            call(*names)
        assert all(name in str(raised.value) for name in EFFECTS)
        assert "\n" not in str(raised.value)


def test_a_record_cannot_be_changed_and_names_are_not_positional() -> None:
    with pytest.raises(FrozenInstanceError):
        Effects().noise = False  # type: ignore[misc]
    with pytest.raises(TypeError):
        Effects(False)  # type: ignore[misc]


@pytest.mark.parametrize("name", EFFECTS)
def test_each_effect_does_something_by_itself(name: str) -> None:
    """The filter alone has only the edges of true surfaces to look at, so it is tried on mixed ones."""
    others = ("mixing",) if name == "filtering" else ()
    with_it, without = image(Effects.only(name, *others)), image(Effects.only(*others))
    different = ~np.isclose(with_it, without, rtol=1e-12, equal_nan=True).all(axis=-1)
    assert different.any()
    assert with_it.shape == without.shape


@pytest.mark.parametrize("name", EFFECTS)
def test_each_effect_is_missed_among_all(name: str) -> None:
    different = ~np.isclose(image(Effects()), image(Effects().without(name)), rtol=1e-12, equal_nan=True).all(axis=-1)
    assert different.any()


@settings(max_examples=10)
@given(st.sets(st.sampled_from(EFFECTS)))
def test_without_a_generator_the_camera_is_perfect_whatever_is_asked_for(names: set[str]) -> None:
    box = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)
    view = corner_view(box)
    perfect = capture(Scene((box,)), view, FAR, rng=None)
    asked = capture(Scene((box,)), view, FAR, rng=None, effects=Effects.only(*names))
    np.testing.assert_array_equal(asked.organised(), perfect.organised())
    np.testing.assert_array_equal(asked.amplitude, perfect.amplitude)

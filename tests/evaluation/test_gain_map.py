"""Maps of what positions around one box are worth: the truth is nobody's opinion, places do not matter, and a turn turns it."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.evaluation import (
    GainMap,
    VolumeSettings,
    case_errors,
    gain_map,
    gain_map_markdown,
    position_scores,
    rank_correlation,
    valued,
    volume_case,
)
from viewgain.evaluation._choice import seen_of
from viewgain.gain import costs
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA
from viewgain.plan import (
    Assessment,
    Belief,
    CombinedPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    FarthestPolicy,
    OnBelief,
    RehearsedPolicy,
    Seen,
    ViewPolicy,
)

SETTINGS = VolumeSettings(seed=5, rig="ring8", captures=2, estimator="lines_published", side=(0.2, 0.5))


@dataclass(frozen=True)
class Fixed:
    """A policy of fixed scores."""

    values: tuple[float, ...]
    name: str = "fixed"

    def scores(self, seen: Seen) -> Vector:
        return np.array(self.values)


def deciders(fused: bool = False) -> list[ViewPolicy]:
    camera = volume_case(SETTINGS, 0).camera
    return [OnBelief(ExpectedErrorPolicy(fused=fused), camera), OnBelief(CovariancePolicy(POSE_SIGMA), camera)]


@pytest.fixture(scope="module")
def plain() -> GainMap:
    return gain_map(SETTINGS, 0, ())


def test_the_truth_depends_on_no_policy_and_is_that_of_the_scans_that_score(plain: GainMap) -> None:
    asked = gain_map(SETTINGS, 0, ("covariance", "farthest"))
    np.testing.assert_array_equal(asked.truth.mean, plain.truth.mean)
    np.testing.assert_allclose(plain.truth.mean, costs(case_errors(plain.case)[:, :2]).mean(axis=1))
    assert [each.name for each in asked.policies] == ["covariance", "farthest"]
    assert [each.meaning for each in asked.policies] == ["sigma_left", "minus_score"]


@pytest.mark.parametrize("policy", deciders(), ids=["expected", "covariance"])
def test_the_order_of_the_positions_carries_the_values_along(policy: ViewPolicy) -> None:
    seen = seen_of(volume_case(SETTINGS, 1))
    order = np.random.default_rng(2).permutation(8)
    before, after = valued(policy, seen), valued(policy, replace(seen, candidates=seen.candidates[order]))
    assert np.all(np.isfinite(before.values))
    assert np.ptp(before.values) > 0
    np.testing.assert_allclose(after.values, before.values[order], rtol=1e-9)


@pytest.mark.parametrize("policy", deciders(), ids=["expected", "covariance"])
def test_a_turn_of_box_and_camera_turns_the_map(policy: ViewPolicy) -> None:
    case = volume_case(SETTINGS, 1)
    seen, about = seen_of(case), case.box.centre
    turn = rotation_from_rotvec(np.array([0.0, 0.0, np.pi / 4]))
    moved = pose(turn, about - turn @ about)
    (scan,) = seen.scans
    turned = replace(
        seen,
        scans=(replace(scan, camera_to_world=moved @ scan.camera_to_world),),
        stands=moved @ seen.stands,
    )
    before, after = valued(policy, seen).values, valued(policy, turned).values
    np.testing.assert_allclose(after, np.roll(before, 1), rtol=1e-6)
    assert not np.allclose(after, before, rtol=1e-3)


def test_directions_are_those_of_the_rig_and_the_yaw_is_that_of_the_box(plain: GainMap) -> None:
    np.testing.assert_allclose(np.rad2deg(plain.azimuth), np.arange(8) * 45.0, atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(plain.elevation), 35.0)
    along = plain.case.box.box_to_camera[:3, 0]
    np.testing.assert_allclose([np.cos(plain.yaw), np.sin(plain.yaw)], along[:2], atol=1e-12)


def test_scores_come_to_one_meaning_whatever_constant_a_policy_adds() -> None:
    seen = seen_of(volume_case(SETTINGS, 1))
    expected = deciders()[0]
    errors = valued(expected, seen)
    assert errors.meaning == "error"
    np.testing.assert_allclose(errors.values, 1 - expected.scores(seen))
    assert np.all((errors.values > 0) & (errors.values <= 1))
    both = valued(CombinedPolicy(expected, deciders()[0]), seen)
    assert both.meaning == "error"
    np.testing.assert_allclose(both.values, errors.values)
    silent = CombinedPolicy(expected, Fixed((np.nan,) * 8))
    assert valued(silent, seen).meaning == "minus_score"
    np.testing.assert_allclose(valued(FarthestPolicy(), seen).values, -FarthestPolicy().scores(seen))


def test_who_rehearses_beside_a_network_is_asked_once_and_says_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a measured box: though the network's scores are of no unit, and nobody asks it."""
    case = volume_case(SETTINGS, 1)
    asked: list[Belief] = []

    def noting(policy: RehearsedPolicy, belief: Belief, candidates: np.ndarray, tolerance: float) -> tuple[Assessment, ...]:
        asked.append(belief)
        return tuple(Assessment(0.9 - 0.05 * place, None, None) for place in range(len(candidates)))

    monkeypatch.setattr(RehearsedPolicy, "assess", noting)
    both = CombinedPolicy(OnBelief(RehearsedPolicy(), case.camera), Fixed((0.5,) * 8))
    said = valued(both, seen_of(case))
    assert (said.meaning, len(asked)) == ("error", 1)
    assert not asked[0].guessed
    np.testing.assert_allclose(said.values, 0.1 + 0.05 * np.arange(8))


def test_rank_correlation_looks_at_allowed_and_known_positions_alone() -> None:
    truth, allowed = np.array([0.1, 0.2, 0.3, 0.4]), np.array([True, True, True, False])
    assert rank_correlation(truth, np.array([1.0, 2.0, 9.0, 0.0]), allowed) == pytest.approx(1.0)
    assert rank_correlation(truth, np.array([3.0, 2.0, 1.0, 9.0]), allowed) == pytest.approx(-1.0)
    assert rank_correlation(truth, np.array([3.0, np.nan, 1.0, 9.0]), allowed) is None
    assert rank_correlation(truth, np.ones(4), allowed) is None


def test_where_nobody_has_an_opinion_the_table_says_so(plain: GainMap) -> None:
    from viewgain.evaluation import PolicyMap

    silent = replace(plain, policies=(PolicyMap("mute", "error", np.full(8, np.nan), None, None),))
    text = gain_map_markdown(silent)
    assert "| mute | expected volume error | no opinion |  |  |" in text
    assert all(line.count("|") == 6 for line in text.splitlines() if line.startswith("|"))
    assert silent.to_dict()["policies"][0]["values"] == [None] * 8  # type: ignore[index]


def test_positions_in_one_direction_have_no_map() -> None:
    with pytest.raises(ConfigError, match="stand in one direction"):
        gain_map(replace(SETTINGS, rig="paper4"), 0, ())


def test_out_of_reach_counts_for_nothing(plain: GainMap) -> None:
    reachable = np.arange(8) != plain.truth.least
    truth = position_scores(np.where(reachable[:, None], case_errors(plain.case)[:, :2], np.nan), reachable)
    assert truth.least != plain.truth.least
    assert np.isnan(truth.mean[plain.truth.least])

"""The table of volume planners from runs that are made up, and boxes from seeds."""

from dataclasses import replace

import numpy as np
import pytest

from viewgain.arrays import Pose
from viewgain.errors import ConfigError, DataError
from viewgain.evaluation import (
    Choice,
    LoopSettings,
    VolumeRun,
    VolumeSettings,
    check_volume_policies,
    volume_case,
    volume_markdown,
    volume_table,
)
from viewgain.evaluation._choice import decisions
from viewgain.evaluation._loop_policies import check_loop_policies
from viewgain.evaluation._shape_choices import check_shape_policies
from viewgain.evaluation._volume_case import _ASIDE, _CASE
from viewgain.evaluation._volume_choices import policy_of, volume_policy
from viewgain.evaluation._volume_errors import _OTHERS
from viewgain.plan import (
    AROUND,
    CombinedPolicy,
    FusedTrial,
    OnBelief,
    RehearsedPolicy,
    VolumeNetworkPolicy,
    looked_at,
)
from viewgain.rigs import poses

SETTINGS = VolumeSettings(captures=6)
POLICIES = ("wise", "random", "constant", "oracle")


def run_of(number: int, best: int, *, chosen: int, present: int = 0) -> VolumeRun:
    """Return a box of which one position measures well, another nearly as well, and two miss."""
    rng = np.random.default_rng(number)
    errors = np.full((4, 12), np.nan)
    errors[best] = rng.normal(0.05, 0.002, 12)
    errors[(best + 1) % 4] = rng.normal(0.065, 0.002, 12)
    return VolumeRun(
        number=number, size=(0.3, 0.2, 0.1), present=present, reachable=np.ones(4, dtype=bool), errors=errors,
        choices={"wise": Choice(chosen, number > 0)}, milliseconds={"wise": 5.0},
    )  # fmt: skip


def test_the_rows_say_what_was_chosen() -> None:
    runs = [run_of(0, 0, chosen=0), run_of(1, 0, chosen=0), run_of(2, 0, chosen=1), run_of(3, 2, chosen=0)]
    table = volume_table(SETTINGS, runs, POLICIES)
    rows = {row.name: row for row in table.rows}
    assert list(rows) == ["wise", "uniform guess", "constant position", "constant offset", "oracle"]
    assert rows["wise"].shares.mean[:2] == (0.5, 0.75)
    assert rows["wise"].shares.mean[2] == pytest.approx((0.05 + 0.05 + 0.065 + 1) / 4, abs=0.003)
    assert (rows["wise"].undecided, rows["wise"].milliseconds) == (1, 5.0)
    assert rows["uniform guess"].shares.mean[:2] == (0.25, 0.5)
    assert rows["constant position"].shares.mean[0] == 0.75
    assert rows["oracle"].shares.mean[:2] == (1.0, 1.0)
    assert table.ceiling.mean == (1.0, 1.0)
    assert rows["wise"].of_ceiling.value == pytest.approx(0.5)
    assert rows["oracle"].to_oracle.value == pytest.approx(1.0)
    assert (table.missed, table.best, table.no_choice) == (0.5, 1.0, 0)
    text = volume_markdown(table)
    assert "| wise | 50.0 (" in text
    assert "| uniform guess | 25.0 (25.0 to 25.0) |" in text


def test_the_constant_offset_counts_from_the_present_position() -> None:
    runs = [run_of(number, best=(number + 2) % 4, chosen=0, present=number % 4) for number in range(8)]
    rows = {row.name: row for row in volume_table(SETTINGS, runs, POLICIES).rows}
    assert rows["constant offset"].shares.mean[0] == 1.0
    # Of the seven other boxes each position but this box's own is best for two: it is never chosen.
    assert rows["constant position"].shares.mean[0] == 0.0


def test_a_table_wants_two_boxes_and_is_plain_json() -> None:
    with pytest.raises(DataError, match="2 or more"):
        volume_table(SETTINGS, [run_of(0, 0, chosen=0)], POLICIES)
    perfect = [
        replace(run_of(number, 0, chosen=1), errors=np.array([[0.0] * 12, [0.5] * 12, [0.5] * 12, [0.5] * 12]))
        for number in (0, 1)
    ]
    content = volume_table(SETTINGS, perfect, POLICIES).to_dict()
    assert content["rows"][0]["to_oracle"]["value"] is None


def test_a_box_depends_on_seed_and_number_alone() -> None:
    one, other = volume_case(SETTINGS, 3), volume_case(replace(SETTINGS, captures=9, estimator="lines_mended"), 3)
    assert np.array_equal(one.box.extents, other.box.extents)
    assert (one.present, one.scans.seed) == (other.present, other.scans.seed)
    assert not np.array_equal(one.box.extents, volume_case(SETTINGS, 4).box.extents)
    assert not np.array_equal(one.box.extents, volume_case(replace(SETTINGS, seed=1), 3).box.extents)


def test_boxes_leave_a_choice_and_lie_within_their_sizes() -> None:
    cases = [volume_case(replace(SETTINGS, side=(0.4, 0.9)), number) for number in range(30)]
    assert all(case.reachable.sum() >= 2 and case.reachable[case.present] for case in cases)
    sides = np.stack([case.box.extents for case in cases])
    assert 0.4 <= sides.min() < sides.max() <= 0.9
    with pytest.raises(ConfigError, match="two positions"):
        volume_case(replace(SETTINGS, side=(4.0, 4.0)), 0)


def test_a_rig_off_centre_is_about_a_point_beside_the_same_box() -> None:
    for number in range(6):
        centred, beside, far = (volume_case(replace(SETTINGS, off_centre=metres), number) for metres in (0.0, 0.02, 0.04))
        assert looked_at(centred.stations) == pytest.approx(centred.box.centre)
        if np.array_equal(beside.box.extents, far.box.extents):  # else one of them was drawn anew, for want of two positions
            one, other = (looked_at(case.stations) - case.box.centre for case in (beside, far))  # type: ignore[operator]
            assert other == pytest.approx(2 * one)
            assert 0 < np.linalg.norm(one) < 0.12
            assert looked_at(np.stack([beside.scans.camera_to_world(view, 3) for view in range(4)])) == pytest.approx(
                beside.box.centre + one
            )


def test_where_the_rig_stands_is_drawn_from_numbers_of_its_own() -> None:
    assert len({_CASE, _ASIDE, _OTHERS}) == 3


def test_who_is_told_of_a_centre_is_not_asked_where_the_rig_looks_at_a_corner() -> None:
    case = volume_case(replace(SETTINGS, rig="paper4"), 0)
    assert policy_of("expected", case).name == "expected"
    for name in ("expected_around", "combined_around:pose_scores-irregular-camera"):
        with pytest.raises(ConfigError, match="got rig paper4, whose stations look at a corner"):
            policy_of(name, case)


def test_cameras_arrive_where_the_rig_sends_them() -> None:
    case = volume_case(SETTINGS, 0)
    scans = case.scans
    jittered = poses(scans.rig, scans.target, elevation=scans.elevation, distance=scans.distance, rng=np.random.default_rng(4))
    assert case.stations @ case.arrivals(np.random.default_rng(4)) == pytest.approx(jittered)
    assert np.linalg.norm((jittered - case.stations)[:, :3, 3], axis=1).max() > 0.05
    still = volume_case(replace(SETTINGS, rig="ring8"), 0)  # a rig without jitter
    assert still.arrivals(np.random.default_rng(4)) == pytest.approx(np.broadcast_to(np.eye(4), (8, 4, 4)))


def test_who_rehearses_is_told_the_question_and_nothing_of_the_answer() -> None:
    cases = [volume_case(replace(SETTINGS, estimator=estimator), 1) for estimator in ("default", "lines_published")]
    for name, around in (("rehearsed", None), ("rehearsed_around", AROUND)):
        asked = [volume_policy(name, case) for case in cases]
        for case, policy in zip(cases, asked, strict=True):
            assert isinstance(policy, OnBelief)
            assert policy.around == around
            rehearsed = policy.policy
            assert isinstance(rehearsed, RehearsedPolicy)
            assert rehearsed.arrivals == case.arrivals
            assert rehearsed.reachable is case.reachable
            assert rehearsed.seed == case.number == 1
        scan = cases[0].seen
        assert scan is not None
        first, second = (each.policy.estimator(scan) for each in asked)  # type: ignore[attr-defined]
        assert first != second


@pytest.mark.parametrize("name", ["rehearsed", "rehearsed_around"])
def test_who_rehearses_beside_a_network_is_told_as_much_as_without_one(name: str) -> None:
    case = volume_case(SETTINGS, 1)
    alone, both = volume_policy(name, case), volume_policy(f"{name}:pose_scores-irregular4-camera", case)
    assert isinstance(both, CombinedPolicy)
    assert isinstance(alone, OnBelief)
    assert both.model.around == alone.around
    assert (both.model.sensor, both.model.policy.name) == (alone.sensor, "rehearsed")
    assert isinstance(both.model.policy, RehearsedPolicy)
    assert both.model.policy.arrivals == alone.policy.arrivals
    assert both.model.policy.reachable is alone.policy.reachable
    assert (both.model.policy.seed, both.model.policy.fused) == (alone.policy.seed, alone.policy.fused)
    assert isinstance(both.network, VolumeNetworkPolicy)


def test_a_second_view_is_rehearsed_with_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    known: list[int] = []
    outcome = FusedTrial.outcome

    def noting(trial: FusedTrial, index: int, camera_to_current: Pose) -> float:
        known.append(len(trial.known))
        return outcome(trial, index, camera_to_current)

    monkeypatch.setattr("viewgain.plan._rehearsed.MOST", 4)
    monkeypatch.setattr(FusedTrial, "outcome", noting)
    case = volume_case(VolumeSettings(seed=5, side=(0.2, 0.4), captures=2, fused=True), 0)
    choices, _ = decisions(case, ["rehearsed"], volume_policy)
    assert choices["rehearsed"].has_opinion
    assert case.reachable[choices["rehearsed"].position]
    assert known
    assert set(known) == {1}


def test_a_rig_in_the_middle_goes_without_saying() -> None:
    """Results of before the question could be asked are answers to it still."""
    runs = [run_of(number, 1, chosen=1) for number in range(3)]
    for asked in (SETTINGS, replace(SETTINGS, off_centre=0.1)):
        told = {
            "question": asked.to_dict(),
            "table": volume_table(asked, runs, POLICIES).to_dict()["settings"],
            "loop": LoopSettings(boxes=replace(asked, fused=True)).to_dict(),
        }
        assert {name: each.get("off_centre") for name, each in told.items()} == dict.fromkeys(told, asked.off_centre or None)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"seed": -1}, "seed -1"),
        ({"captures": 1}, "1 captures"),
        ({"side": (0.5, 0.2)}, "sides"),
        ({"side": (np.nan, 0.2)}, "sides"),
        ({"side": (0.1, np.nan)}, "sides"),
        ({"side": (0.1, np.inf)}, "sides"),
        ({"distance": 0.0}, "distance 0.0"),
        ({"distance": np.nan}, "distance nan"),
        ({"distance": np.inf}, "distance inf"),
        ({"elevation_deg": np.nan}, "elevation nan"),
        ({"elevation_deg": np.inf}, "elevation inf"),
        ({"elevation_deg": -np.inf}, "elevation -inf"),
        ({"estimator": "guess"}, "estimator"),
        ({"fused": True, "estimator": "lines_mended"}, "cannot fuse"),
        ({"rig": "nowhere"}, "rig 'nowhere'"),
        ({"camera": "eye"}, "camera 'eye'"),
        ({"off_centre": -0.1}, "-0.1 m off centre"),
        ({"off_centre": np.nan}, "nan m off centre"),
        ({"off_centre": np.inf}, "inf m off centre"),
    ],
)
def test_settings_that_make_no_sense_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        VolumeSettings(**change)  # type: ignore[arg-type]


def test_unknown_policies_are_refused() -> None:
    check_volume_policies(("expected", "rehearsed", "rehearsed_around", "network:some.onnx", "combined_around:some.onnx"))
    check_volume_policies(("rehearsed:some.onnx", "rehearsed_around:some.onnx", "rehearsed:other.onnx"))
    for check in (check_shape_policies, check_loop_policies):  # there a position is judged by no scans of a box
        for name in ("rehearsed", "rehearsed:some.onnx", "rehearsed_around:some.onnx"):
            with pytest.raises(ConfigError, match=f"'{name}' is not known"):
                check((name,))
    for name in ("best", "model", "network:", "expected:some.onnx", "expected_around:some.onnx", "combined_around"):
        with pytest.raises(ConfigError, match=f"'{name}' is not known; choose from expected, expected_around, covariance"):
            check_volume_policies((name,))
    with pytest.raises(ConfigError, match="each once"):
        check_volume_policies(("expected", "expected"))


def test_who_goes_by_other_cameras_is_a_row_of_its_own() -> None:
    runs = [
        replace(run_of(k, 0, chosen=0), by_others=run_of(k + 9, 1 if k == 2 else 0, chosen=0).errors[:, :6]) for k in range(4)
    ]
    (row,) = volume_table(SETTINGS, runs, ("informed",)).rows
    assert row.name == "informed (other cameras)"
    assert row.shares.mean[0] == 0.75
    with pytest.raises(DataError, match="by other cameras"):
        volume_table(SETTINGS, [replace(run, by_others=None) for run in runs], ("informed",))

"""Trying candidates out before going there: what a rehearsal is, who is rehearsed, and what comes of it."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewgain.arrays import Poses
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.errors import ConfigError, ScanError
from viewgain.gain import VolumeEstimator, volume_estimator
from viewgain.geometry import inverse, look_at, pose, rotation_from_rotvec, transform
from viewgain.inference import PoseScorer, volume_scorer
from viewgain.measure import Knowledge, measure
from viewgain.plan import (
    Belief,
    CombinedPolicy,
    ExpectedErrorPolicy,
    FarthestPolicy,
    NextView,
    OnBelief,
    RehearsedPolicy,
    Seen,
    Trial,
    VolumeNetworkAboutBox,
    arriving_within,
    believe,
    next_view,
    trials,
    trust_in,
)
from viewgain.plan._rehearsal import as_noisy
from viewgain.plan._rehearsed import MOST, ROUND, WORTH, Standing
from viewgain.rays import SceneCaster
from viewgain.rigs import KeepOut, rig
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import NO_ERROR, RangeError, capture

CAMERA = sensor("pico_flexx")
UP = np.array([0.0, 0.0, 1.0])
BOX = Box(pose(rotation_from_rotvec(0.7 * UP), np.array([0.2, -0.1, 0.0])), np.array([0.35, 0.25, 0.2]))
EXACTLY = arriving_within(3, (0.0, 0.0))


def cameras(*azimuths: float) -> Poses:
    centre = BOX.centre
    places = [centre + np.array([np.cos(azimuth), np.sin(azimuth), 0.8]) for azimuth in azimuths]
    return np.stack([look_at(place, centre, UP) for place in places])


CANDIDATES = cameras(0.3, 2.0, 4.1)


def belief_in(*boxes: Box, guessed: bool = False) -> Belief:
    return Belief(boxes, Knowledge(1e6 * np.eye(9), np.zeros((9, 4))), CAMERA, 1.0, bounded=len(boxes) == 1, guessed=guessed)


def scaled(factor: float) -> Box:
    return Box(BOX.box_to_camera, factor * BOX.extents)


def trial_of(box: Box, error: RangeError = NO_ERROR) -> Trial:
    caster = SceneCaster(Scene((Box(np.eye(4), box.extents),)))
    return Trial(0, box, caster, CAMERA, error, EXACTLY(np.random.default_rng(0)), 3)


def by_place(*errors: float) -> VolumeEstimator:
    """Return an estimator that is off by so much from each of the three candidates: wherever its scan was taken from."""
    places = places_of(CANDIDATES)

    def estimator(scan: Scan) -> float:
        assert scan.camera_to_world is not None
        index = int(np.argmin(np.linalg.norm(places - scan.camera_to_world[:3, 3], axis=1)))
        return BOX.volume * (1 + errors[index])

    return estimator


def places_of(candidates: Poses) -> np.ndarray:
    return (inverse(BOX.box_to_camera) @ candidates)[:, :3, 3]


def silent(scan: Scan) -> float:
    raise AssertionError(f"{scan.source}: nobody should rehearse")


def scores(policy: RehearsedPolicy, belief: Belief) -> np.ndarray:
    return np.array([each.score for each in policy.assess(belief, CANDIDATES, 0.05)])


def expected(belief: Belief) -> np.ndarray:
    return np.array([each.score for each in ExpectedErrorPolicy(fused=False).assess(belief, CANDIDATES, 0.05)])


# One rehearsal.


def test_a_rehearsal_is_a_scan_of_that_box_from_there_and_its_measurement() -> None:
    """Held against the same scene in the frame of the world: the box where it is believed to stand."""
    estimator = volume_estimator("default", CAMERA)
    scan = capture(Scene((BOX,)), CANDIDATES[1], CAMERA, rng=np.random.default_rng(3))
    outcome = trial_of(BOX).outcome(1, CANDIDATES[1], estimator)
    assert outcome == pytest.approx(abs(estimator(scan) / BOX.volume - 1), abs=2e-4)
    assert 0 < outcome < 0.1
    longer = trial_of(BOX, RangeError(0.1, 0.0)).outcome(1, CANDIDATES[1], estimator)
    assert longer == pytest.approx(1.1**3 - 1, abs=0.08)  # every range, so every side, by a tenth


@pytest.mark.parametrize(("volume", "cost"), [(1.0, 0.0), (1.25, 0.25), (0.4, 0.6), (5.0, 1.0), (np.nan, 1.0), (np.inf, 1.0)])
def test_what_a_rehearsal_costs(volume: float, cost: float) -> None:
    assert trial_of(BOX).outcome(0, CANDIDATES[0], lambda scan: BOX.volume * volume) == pytest.approx(cost)


def test_an_estimator_that_nobody_can_ask_is_no_miss() -> None:
    with pytest.raises(ConfigError, match="pico_flex"):
        scores(RehearsedPolicy(estimator=volume_estimator("default", "pico_flex")), belief_in(BOX))


def test_an_estimator_that_fails_has_missed_and_so_has_a_camera_that_sees_nothing() -> None:
    def failing(scan: Scan) -> float:
        raise ScanError(f"{scan.source}: no floor")

    def singular(scan: Scan) -> float:
        raise np.linalg.LinAlgError

    assert trial_of(BOX).outcome(0, CANDIDATES[0], failing) == 1.0
    assert trial_of(BOX).outcome(0, CANDIDATES[0], singular) == 1.0
    away = CANDIDATES[0] @ pose(rotation_from_rotvec(np.array([np.pi, 0.0, 0.0])), np.zeros(3))
    assert trial_of(BOX).outcome(0, away, silent) == 1.0


def test_every_box_comes_once_before_any_comes_again() -> None:
    boxes = tuple(scaled(factor) for factor in (0.8, 0.9, 1.0, 1.2, 1.5))
    drawn = list(islice(trials(belief_in(*boxes), EXACTLY, np.random.default_rng(1)), 15))
    orders = [tuple(trial.of for trial in drawn[start : start + 5]) for start in (0, 5, 10)]
    assert all(sorted(order) == [0, 1, 2, 3, 4] for order in orders)
    assert len(set(orders)) > 1
    assert all(trial.box is boxes[trial.of] for trial in drawn)
    assert all(np.array_equal(trial.caster.scene.boxes[0].extents, trial.box.extents) for trial in drawn)
    assert all(np.array_equal(trial.caster.scene.boxes[0].box_to_camera, np.eye(4)) for trial in drawn)
    assert len({trial.seed for trial in drawn}) == len({trial.error.scale for trial in drawn}) == 15
    again = list(islice(trials(belief_in(*boxes), EXACTLY, np.random.default_rng(1)), 15))
    assert [(trial.of, trial.seed, trial.error) for trial in again] == [(trial.of, trial.seed, trial.error) for trial in drawn]


def noise_of(camera: Sensor) -> float:
    """Of a range of a metre, head on."""
    return float(camera.range_sigma(np.ones(1), np.ones(1))[0])


def noisy_belief(factor: float, seed: int = 2) -> Belief:
    """What is believed after a scan by a camera with so many times the noise of its data sheet."""
    scan = capture(Scene((BOX,)), CANDIDATES[0], CAMERA.noisier(factor), rng=np.random.default_rng(seed))
    belief = believe(measure(scan, camera=CAMERA), CAMERA)
    assert belief is not None
    return belief


@pytest.mark.parametrize("factor", [1.0, 1.5, 2.0, 3.0, 4.0])
def test_a_rehearsal_is_as_noisy_as_the_scan(factor: float) -> None:
    """Though measuring finds too little the more there is: 2.6 times the data sheet's where there is 3 times that."""
    found = [noise_of(as_noisy(noisy_belief(factor, seed), np.random.default_rng(seed))) for seed in range(5)]
    louder = noise_of(CAMERA.noisier(factor))
    assert louder == pytest.approx(factor * noise_of(CAMERA))
    assert found == pytest.approx([louder] * 5, rel=0.16)
    assert np.mean(found) == pytest.approx(louder, rel=0.07)


@pytest.mark.parametrize("noise", [7.0, 10.0, 20.0])
def test_nothing_is_rehearsed_so_noisily_that_no_box_is_found(noise: float) -> None:
    """Every rehearsal would be a miss; the scan that is known did show one. Of ten times the noise none does."""
    deaf = capture(Scene((BOX,)), CANDIDATES[0], CAMERA.noisier(10.0), rng=np.random.default_rng(0))
    assert not measure(deaf, camera=CAMERA).boxes
    belief = replace(noisy_belief(3.0), noise=noise)
    camera = as_noisy(belief, np.random.default_rng(0))
    assert noise_of(camera) > 2 * noise_of(CAMERA)
    scans = [capture(Scene((BOX,)), CANDIDATES[0], camera, rng=np.random.default_rng(seed)) for seed in range(4)]
    assert sum(len(measure(scan, camera=CAMERA).boxes) for scan in scans) >= 3


def test_what_cannot_be_compared_is_rehearsed_by_the_data_sheet() -> None:
    belief = noisy_belief(3.0)
    assert as_noisy(replace(belief, noise=0.5), np.random.default_rng(0)) == CAMERA
    away = replace(belief, boxes=(BOX.in_frame(pose(np.eye(3), np.array([0.0, 0.0, -9.0]))),))  # behind the camera
    assert as_noisy(away, np.random.default_rng(0)) == CAMERA


def test_noise_is_compared_from_where_the_box_was_seen() -> None:
    belief = noisy_belief(3.0)
    simulated = as_noisy(belief, np.random.default_rng(0))
    assert simulated.jitter_px == CAMERA.jitter_px
    assert noise_of(next(trials(belief, EXACTLY, np.random.default_rng(0))).sensor) == noise_of(simulated)
    turned = pose(rotation_from_rotvec(np.array([np.pi, 0.0, 0.0])), np.zeros(3))
    earlier = replace(belief, boxes=(belief.mean.in_frame(turned),), cameras=turned[None])  # seen by another camera than this
    assert noise_of(as_noisy(earlier, np.random.default_rng(0))) == pytest.approx(noise_of(simulated), rel=1e-6)


def test_cameras_arrive_about_their_candidates() -> None:
    rng = np.random.default_rng(5)
    moves = np.concatenate([arriving_within(2, (0.02, 0.01))(rng) for _ in range(400)])
    assert moves.shape == (800, 4, 4)
    assert moves[:, :3, 3].std(axis=0) == pytest.approx([0.02] * 3, rel=0.1)
    angles = np.arccos(np.clip((np.trace(moves[:, :3, :3], axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert np.sqrt(np.mean(angles**2) / 3) == pytest.approx(0.01, rel=0.1)
    assert EXACTLY(rng) == pytest.approx(np.broadcast_to(np.eye(4), (3, 4, 4)))


def test_a_camera_that_arrives_elsewhere_is_rehearsed_there() -> None:
    trial = trial_of(BOX)
    trial.arrived[0] = inverse(CANDIDATES[0]) @ CANDIDATES[2]
    assert trial.outcome(0, CANDIDATES[0], by_place(0.0, 0.1, 0.2)) == pytest.approx(0.2)


# Who is rehearsed.

ERRORS = st.floats(0.0, 1.0)


@given(expectation=ERRORS, outcomes=st.lists(ERRORS, max_size=30))
@settings(deadline=None)
def test_an_expectation_counts_as_so_many_rehearsals(expectation: float, outcomes: list[float]) -> None:
    standing = Standing.before(np.array([expectation, 0.5]))
    for outcome in outcomes:
        standing = standing.after(np.array([0]), np.array([outcome - expectation]))
    mean = (WORTH * expectation + sum(outcomes)) / (WORTH + len(outcomes))
    assert standing.errors == pytest.approx([mean, 0.5])
    assert standing.tried.tolist() == [len(outcomes), 0]
    assert standing.sigma[0] == pytest.approx(np.sqrt(mean * (1 - mean) / (WORTH + len(outcomes) + 1)), abs=1e-7)


@given(expectation=st.lists(ERRORS, min_size=1, max_size=6), mask=st.lists(st.booleans(), min_size=6, max_size=6))
@settings(deadline=None)
def test_the_best_that_can_be_reached_contends_and_what_cannot_does_not(expectation: list[float], mask: list[bool]) -> None:
    allowed = np.array(mask[: len(expectation)])
    if allowed.any():
        found = Standing.before(np.array(expectation)).contenders(allowed)
        assert np.all(allowed[found])
        best = np.flatnonzero(allowed)[np.argmin(np.array(expectation)[allowed])]
        assert best in found


def test_who_is_surely_worse_contends_no_longer_and_more_rehearsals_tell_more_apart() -> None:
    standing = Standing.before(np.array([0.02, 0.4, 0.95]))
    everybody = np.ones(3, dtype=bool)
    assert standing.contenders(everybody).tolist() == [0, 1]
    assert standing.contenders(np.array([False, True, True])).tolist() == [1]
    for _ in range(20):  # each comes out as it was expected to
        standing = standing.after(np.array([0, 1]), np.zeros(2))
    assert standing.contenders(everybody).tolist() == [0]


def test_rehearsals_overrule_an_expectation() -> None:
    belief = belief_in(BOX)
    before = expected(belief)
    best = int(np.argmax(before))
    errors = [0.02, 0.02, 0.02]
    errors[best] = 1.0
    after = scores(RehearsedPolicy(estimator=by_place(*errors), arrivals=EXACTLY), belief)
    assert np.argmax(after) != best
    assert after[best] < 0.5 < before[best]


def test_scores_are_the_mean_of_expectation_and_rehearsals() -> None:
    """Slow twin: every candidate that contends to the end is rehearsed so often as is allowed."""
    belief = belief_in(BOX)
    after = scores(RehearsedPolicy(estimator=by_place(0.05, 0.05, 0.05), arrivals=EXACTLY), belief)
    wanted = 1 - (WORTH * (1 - expected(belief)) + MOST * 0.05) / (WORTH + MOST)
    assert after == pytest.approx(wanted)


def test_of_several_boxes_each_is_held_against_what_was_expected_of_it() -> None:
    """A box that is hard to measure comes up in a rehearsal: no surprise, so nothing is learned from it."""
    belief, policy = belief_in(*(scaled(factor) for factor in (0.5, 0.7, 1.0, 1.5, 2.0))), ExpectedErrorPolicy(fused=False)
    rehearsed = islice(trials(belief, EXACTLY, np.random.default_rng(0)), MOST)
    volumes = [trial.box.volume * (1 + policy.errors(belief_in(trial.box), CANDIDATES)[0]) for trial in rehearsed]
    answers = iter(np.concatenate(volumes).tolist())
    after = scores(RehearsedPolicy(estimator=lambda scan: next(answers), arrivals=EXACTLY), belief)
    assert next(answers, None) is None  # all three contended throughout, or the answers were given to others
    assert after == pytest.approx(expected(belief))


def test_nobody_is_rehearsed_where_there_is_nothing_to_choose_or_the_box_is_a_guess() -> None:
    guess = belief_in(BOX, guessed=True)
    assert scores(RehearsedPolicy(estimator=silent), guess) == pytest.approx(expected(guess))
    belief = belief_in(BOX)
    for mask in ([False, False, False], [False, True, False]):
        policy = RehearsedPolicy(estimator=silent, reachable=np.array(mask))
        assert scores(policy, belief) == pytest.approx(expected(belief))
        assert {each.sigma for each in policy.assess(belief, CANDIDATES, 0.05)} == {None}
    with pytest.raises(ConfigError, match=r"got reachable \(2,\) for 3 candidates"):
        scores(RehearsedPolicy(reachable=np.array([True, True])), belief)


def test_a_favourite_is_tried_and_left_if_it_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """The formula is all but certain, and wrong: who goes by it alone goes to the one place from where nothing is measured."""
    monkeypatch.setattr(ExpectedErrorPolicy, "errors", lambda *arguments: np.array([[0.02, 0.8, 0.9]]))
    asked: list[int] = []
    off = by_place(1.0, 0.01, 0.01)

    def noting(scan: Scan) -> float:
        volume = off(scan)
        asked.append(int(volume < 1.5 * BOX.volume))
        return volume

    after = scores(RehearsedPolicy(estimator=noting, arrivals=EXACTLY), belief_in(BOX))
    assert np.argmax(after) != 0
    assert asked[:ROUND] == [0] * ROUND  # the favourite alone, at first
    assert asked.count(0) < MOST  # and not to the end


def test_what_cannot_be_reached_is_not_rehearsed() -> None:
    belief = belief_in(BOX)
    mask = np.array([True, False, True])
    after = scores(RehearsedPolicy(estimator=by_place(0.3, 0.3, 0.3), arrivals=EXACTLY, reachable=mask), belief)
    assert after[1] == pytest.approx(expected(belief)[1])
    assert np.all(np.abs(after - expected(belief))[mask] > 0.05)


def test_the_same_question_has_the_same_answer_in_every_frame() -> None:
    moved = pose(rotation_from_rotvec(np.array([0.2, -0.4, 1.0])), np.array([1.0, 2.0, -0.5]))
    belief, elsewhere = belief_in(BOX), belief_in(BOX.in_frame(moved))
    policy = RehearsedPolicy(estimator=lambda scan: BOX.volume * float(np.nanmean(scan.points[:, 2])))
    first = policy.assess(belief, CANDIDATES, 0.05)
    assert [each.score for each in policy.assess(belief, CANDIDATES, 0.05)] == [each.score for each in first]
    again = policy.assess(elsewhere, moved @ CANDIDATES, 0.05)
    assert [each.score for each in again] == pytest.approx([each.score for each in first], abs=1e-5)
    assert np.ptp([each.score for each in first]) > 0.003
    tried = [each.sigma for each in first if each.sigma is not None]
    assert tried
    assert all(0 < sigma < 0.2 for sigma in tried)


def test_whoever_knows_enough_rehearses_nothing() -> None:
    scan = capture(Scene((BOX,)), CANDIDATES[0], CAMERA, rng=np.random.default_rng(1))
    asked: list[Scan] = []

    def noting(seen: Scan) -> float:
        asked.append(seen)
        return BOX.volume

    def plan(tolerance: float) -> NextView:
        return next_view(scan, policy=RehearsedPolicy(estimator=noting), camera="pico_flexx", tolerance=tolerance)

    loose = plan(0.5)
    assert loose.stop
    assert not asked
    assert loose.best is not None  # where it would go is still said
    assert not plan(0.001).stop
    assert asked


def test_next_view_spends_nothing_on_what_is_out_of_reach() -> None:
    """A ring of eight of which the camera may reach one side."""
    scan = capture(Scene((BOX,)), CANDIDATES[0], CAMERA, rng=np.random.default_rng(1))
    cone = KeepOut(axis=CANDIDATES[0][:3, 3] - BOX.centre, half_angle=1.2, apex=BOX.centre)
    tried: list[np.ndarray] = []

    def noting(seen: Scan) -> float:
        assert seen.camera_to_world is not None
        tried.append(seen.camera_to_world[:3, 3])
        return BOX.volume * 1.05

    ring, policy = replace(rig("ring8"), keep_out=(cone,)), RehearsedPolicy(estimator=noting)
    plan = next_view(scan, ring, policy=policy, camera="pico_flexx", tolerance=0.001)
    reached = np.array([candidate.reachable for candidate in plan.candidates])
    assert 1 < reached.sum() < 8
    measured = plan.current.boxes[0].box
    there = transform(inverse(measured.box_to_camera), np.array([each.camera_to_current[:3, 3] for each in plan.candidates]))
    nearest = {int(np.argmin(np.linalg.norm(there - place, axis=1))) for place in tried}
    assert nearest
    assert nearest <= set(np.flatnonzero(reached).tolist())


# Beside a network.


def looking(index: int) -> Scan:
    return capture(Scene((BOX,)), CANDIDATES[index], CAMERA, rng=np.random.default_rng(1)).posed(CANDIDATES[index])


def test_a_model_that_rehearses_is_trusted_wherever_there_is_a_box_to_rehearse() -> None:
    bounded, still_open = belief_in(BOX), belief_in(BOX, scaled(1.5))
    for fused in (False, True):
        model = RehearsedPolicy(fused=fused)
        assert [trust_in(model, each) for each in (bounded, still_open)] == [1.0, 1.0]
        assert [trust_in(model, each) for each in (belief_in(BOX, guessed=True), None)] == [0.0, 0.0]
    glimpsed = replace(belief_in(BOX, scaled(1.5), guessed=True), glimpsed=True)  # nothing is rehearsed: the formula's own share
    assert trust_in(RehearsedPolicy(fused=True), glimpsed) == trust_in(ExpectedErrorPolicy(), glimpsed) == 0.75


def test_a_box_that_is_measured_is_left_to_rehearsals_and_any_other_to_the_network() -> None:
    """The whole policy of ``evaluate volume``, from a scan of the box and from one of a bare floor."""
    model = OnBelief(RehearsedPolicy(estimator=by_place(0.3, 0.01, 0.3), arrivals=EXACTLY), CAMERA)
    network = FarthestPolicy()
    both = CombinedPolicy(model, network)
    scan = looking(0)
    seen = Seen((scan,), CANDIDATES[:1], CANDIDATES, (0,), CAMERA.intrinsics)
    assert both.scores(seen) == pytest.approx(model.scores(seen))
    assert not np.array_equal(np.argsort(both.scores(seen)), np.argsort(network.scores(seen)))
    bare = capture(Scene(), CANDIDATES[0], CAMERA, rng=np.random.default_rng(1)).posed(CANDIDATES[0])
    nothing = replace(seen, scans=(bare,))
    assert np.isnan(model.scores(nothing)).all()
    assert both.scores(nothing) == pytest.approx(network.scores(nothing))


def test_about_a_box_the_network_is_asked_where_nothing_can_be_rehearsed(monkeypatch: pytest.MonkeyPatch) -> None:
    network, scan, belief = volume_scorer(), looking(0), belief_in(BOX)
    rehearsing = RehearsedPolicy(estimator=by_place(0.3, 0.01, 0.3), arrivals=EXACTLY)
    alone, both = VolumeNetworkAboutBox(network, scan), VolumeNetworkAboutBox(network, scan, rehearsing)
    assert (alone.name, both.name) == ("network", "rehearsed")
    guess = belief_in(BOX, guessed=True)
    scored = [[each.score for each in policy.assess(guess, CANDIDATES, 0.05)] for policy in (both, alone)]
    assert scored[0] == pytest.approx(scored[1])
    monkeypatch.setattr(PoseScorer, "assessed", silent)  # nobody needs it where the box is known
    mask = np.array([True, False, True])
    for one, other in ((both, rehearsing), (both.among(mask), rehearsing.among(mask))):
        said, wanted = (policy.assess(belief, CANDIDATES, 0.05) for policy in (one, other))
        assert [(each.score, each.sigma) for each in said] == [(each.score, each.sigma) for each in wanted]
    assert said[1].sigma is None  # what cannot be reached is not tried
    assert said[0].sigma is not None
    assert alone.among(mask) is alone

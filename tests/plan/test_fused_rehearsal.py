"""Rehearsing a second view: the scans so far are taken anew, of the box that is tried and by the camera that is tried."""

from dataclasses import replace

import numpy as np
import pytest

from viewgain.arrays import Poses
from viewgain.box import Box
from viewgain.camera import sensor
from viewgain.errors import ConfigError
from viewgain.gain import measured_volume, volume_estimator
from viewgain.geometry import inverse, look_at, pose, rotation_from_rotvec
from viewgain.measure import Knowledge, fuse, measure
from viewgain.plan import Belief, ExpectedErrorPolicy, FusedTrial, RehearsedPolicy, Trial, arriving_within, believe, fused_trial
from viewgain.plan._rehearsed import MOST, WORTH
from viewgain.rays import SceneCaster
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import NO_ERROR, RangeError, capture

CAMERA = sensor("pico_flexx")
UP = np.array([0.0, 0.0, 1.0])
BOX = Box(pose(rotation_from_rotvec(0.7 * UP), np.array([0.2, -0.1, 0.0])), np.array([0.35, 0.25, 0.2]))
AWAY = pose(rotation_from_rotvec(np.array([np.pi, 0.0, 0.0])), np.zeros(3))
"""Turns a camera round, so that it sees nothing."""
SIGMA = (0.003, 0.005)
SEED = 3


def cameras(*azimuths: float) -> Poses:
    centre = BOX.centre
    places = [centre + np.array([np.cos(azimuth), np.sin(azimuth), 0.8]) for azimuth in azimuths]
    return np.stack([look_at(place, centre, UP) for place in places])


FIRST, CANDIDATES = cameras(5.0)[0], cameras(0.3, 2.0, 4.1)
"""World poses; the box's frame of reference below is the first camera's."""
SEEN = BOX.in_frame(inverse(FIRST))
THERE = inverse(FIRST) @ CANDIDATES


def trial_of(error: RangeError = NO_ERROR) -> Trial:
    arrived = arriving_within(len(THERE), (0.0, 0.0))(np.random.default_rng(0))
    return Trial(0, SEEN, SceneCaster(Scene((Box(np.eye(4), BOX.extents),))), CAMERA, error, arrived, SEED)


def fused_of(error: RangeError = NO_ERROR) -> FusedTrial:
    return fused_trial(trial_of(error), np.eye(4)[None], CAMERA, SIGMA)


@pytest.mark.parametrize("before", [cameras(5.0), cameras(5.0, 1.2)])
def test_it_is_the_scan_from_there_fused_with_those_so_far(before: Poses) -> None:
    """Held against the same scene in the frame of the world, with the same noise, and poses known as badly."""
    rng = np.random.default_rng([SEED, 1])
    misses = arriving_within(len(before) + 3, SIGMA)(rng)

    def scan(camera: np.ndarray, miss: np.ndarray, noise: np.random.Generator) -> Scan:
        return capture(Scene((BOX,)), camera, CAMERA, rng=noise).posed(camera @ miss)

    known = [scan(camera, miss, rng) for camera, miss in zip(before, misses, strict=False)]
    fused = fused_trial(trial_of(), inverse(FIRST) @ before, CAMERA, SIGMA)
    found = []
    for index, there in enumerate(CANDIDATES):
        added = scan(there, misses[len(before) + index], np.random.default_rng(SEED))
        together = measured_volume(fuse([*known, added], camera=CAMERA, pose_sigma=SIGMA))
        outcome = fused.outcome(index, THERE[index])
        assert outcome == pytest.approx(abs(together / BOX.volume - 1), abs=2e-4)
        found.append(outcome)
    assert len(set(found)) == 3
    assert max(found) < 0.1


def test_all_scans_of_a_trial_are_by_one_camera() -> None:
    """Every range a tenth too long in both scans: every side a tenth too long. Of two cameras the other would deny it."""
    assert fused_of(RangeError(0.1, 0.0)).outcome(0, THERE[0]) == pytest.approx(1.1**3 - 1, abs=0.06)


def test_who_arrives_and_sees_nothing_knows_what_was_known() -> None:
    fused = fused_of()
    alone = measured_volume(fused.known[0])
    assert fused.outcome(0, THERE[0] @ AWAY) == pytest.approx(abs(alone / BOX.volume - 1))
    assert replace(fused, known=()).outcome(0, THERE[0] @ AWAY) == 1.0
    blind = fused_trial(trial_of(), AWAY[None], CAMERA, SIGMA)
    assert blind.known == ()
    assert blind.outcome(0, THERE[0]) == pytest.approx(
        trial_of().outcome(0, THERE[0], volume_estimator("default", CAMERA)), abs=2e-4
    )


def test_what_is_believed_knows_from_where_the_box_was_seen() -> None:
    scans = [
        capture(Scene((BOX,)), camera, CAMERA, rng=np.random.default_rng(seed)).posed(camera)
        for seed, camera in enumerate(CANDIDATES[:2])
    ]
    one, both = believe(measure(scans[0], camera=CAMERA), CAMERA), believe(fuse(scans, camera=CAMERA), CAMERA)
    assert one is not None
    assert both is not None
    assert one.cameras == pytest.approx(np.eye(4)[None])
    places = sorted(both.cameras[:, :3, 3].tolist(), key=np.linalg.norm)
    assert places[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert places[1] == pytest.approx((inverse(CANDIDATES[1]) @ CANDIDATES[0])[:3, 3], abs=0.02)


def belief() -> Belief:
    return Belief((SEEN,), Knowledge(1e6 * np.eye(9), np.zeros((9, 5))), CAMERA, 1.0, bounded=True)


def test_scores_are_the_mean_of_the_fused_expectation_and_fused_rehearsals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FusedTrial, "outcome", lambda trial, index, pose: 0.05)
    assessed = RehearsedPolicy(fused=True).assess(belief(), THERE, 0.05)
    expected = np.array([each.score for each in ExpectedErrorPolicy(fused=True).assess(belief(), THERE, 0.05)])
    wanted = 1 - (WORTH * (1 - expected) + MOST * 0.05) / (WORTH + MOST)
    assert [each.score for each in assessed] == pytest.approx(wanted.tolist())
    assert not np.allclose(
        expected, [each.score for each in ExpectedErrorPolicy(fused=False).assess(belief(), THERE, 0.05)], rtol=1e-3
    )


def test_cameras_arrive_as_exactly_as_poses_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    arrived: list[np.ndarray] = []

    def noting(trial: FusedTrial, index: int, camera_to_current: np.ndarray) -> float:
        arrived.append(trial.trial.arrived[index, :3, 3])
        return 0.05

    monkeypatch.setattr(FusedTrial, "outcome", noting)
    for metres in (0.003, 0.05):
        arrived.clear()
        RehearsedPolicy(fused=True, pose_sigma=(metres, 0.001)).assess(belief(), THERE, 0.05)
        assert np.std(arrived) == pytest.approx(metres, rel=0.2)


def test_nobody_fuses_but_the_default_estimator() -> None:
    with pytest.raises(ConfigError, match="which measures scans alone"):
        RehearsedPolicy(volume_estimator("default", CAMERA), fused=True).assess(belief(), THERE, 0.05)

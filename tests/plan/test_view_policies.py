"""General policies: what they score by hand, ties, what they must not depend on, and the two adapters."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.scenes import CAMERA, corner_view, scan_of
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, ScanError
from viewgain.gain import VOLUMETRIC, OcclusionAware
from viewgain.geometry import look_at, pose
from viewgain.measure import POSE_SIGMA, measure
from viewgain.plan import (
    CovariancePolicy,
    FarthestPolicy,
    Mapper,
    OnBelief,
    OnScans,
    Policy,
    RandomPolicy,
    Seen,
    UniformPolicy,
    ViewPolicy,
    VolumetricPolicy,
    choose,
    next_view,
    spread_order,
    visited_among,
)
from viewgain.rigs import Target, poses, rig
from viewgain.scans import Scan
from viewgain.scenes import standing_box
from viewgain.voxels import CERTAIN, Lattice, VoxelGrid, evidence

SMALL = Intrinsics(width=64, height=48, fx=50.0, fy=50.0, cx=31.5, cy=23.5)
RING = poses(rig("ring8"), Target.at(np.zeros(3)), elevation=0.5, distance=1.0)
BOX = standing_box(np.array([0.4, 0.3, 0.2]))


def after(*visited: int, candidates: np.ndarray = RING, scans: tuple[Scan, ...] = ()) -> Seen:
    return Seen(scans, candidates[list(visited)], candidates, tuple(dict.fromkeys(visited)), SMALL)


@dataclass(frozen=True)
class Liking:
    """A general policy that likes candidates as it is told."""

    values: tuple[float, ...]
    name: str = "liking"

    def scores(self, seen: Seen) -> np.ndarray:
        assert len(seen.candidates) == len(self.values)
        return np.array(self.values)


def test_the_best_allowed_candidate_is_chosen_and_of_equal_ones_the_lowest() -> None:
    scores = np.array([1.0, 3.0, 3.0, 9.0, np.nan])
    assert choose(scores, np.ones(5, bool)) == 3
    assert choose(scores, np.array([1, 1, 1, 0, 1], bool)) == 1
    assert choose(scores, np.array([0, 0, 0, 0, 1], bool)) == 4
    assert choose(np.array([np.nan, -np.inf]), np.ones(2, bool)) == 0
    assert choose(np.array([np.nan, -1e300]), np.ones(2, bool)) == 1
    assert choose(scores, np.zeros(5, bool)) is None
    with pytest.raises(ConfigError):
        choose(scores, np.ones(4, bool))


@given(st.integers(1, 70))
def test_the_spread_order_visits_each_once_and_halves_the_way_each_time(count: int) -> None:
    order = spread_order(count)
    np.testing.assert_array_equal(np.sort(order), np.arange(count))
    for power in range(1, 7):
        if 2**power <= count:
            gaps = np.diff(np.sort(np.append(order[: 2**power], count)))
            assert gaps.max() - gaps.min() <= 1


def test_uniform_by_hand() -> None:
    assert spread_order(8).tolist() == [0, 4, 2, 6, 1, 5, 3, 7]
    assert spread_order(5).tolist() == [0, 2, 1, 3, 4]
    order = [3]
    while len(order) < 8:
        seen = after(*order)
        order.append(choose(UniformPolicy().scores(seen), seen.unvisited))
    assert order == [3, 7, 5, 1, 4, 0, 6, 2]
    assert choose(UniformPolicy().scores(after(3, 7)), np.ones(8, bool)) == 5  # a visited one comes after all others


def test_farthest_by_hand() -> None:
    scores = FarthestPolicy().scores(after(0))
    turned = np.deg2rad(45 * np.arange(8))
    np.testing.assert_allclose(scores, 2 * np.cos(0.5) * np.abs(np.sin(turned / 2)), atol=1e-9)
    assert choose(scores, np.ones(8, bool)) == 4
    assert choose(FarthestPolicy().scores(after(0, 4)), np.ones(8, bool)) == 2  # 2 and 6 are equally far
    assert choose(FarthestPolicy().scores(after(0, 4, 2)), np.ones(8, bool)) == 6


def test_random_is_repeatable_and_uniform() -> None:
    one, other = (RandomPolicy(np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one.scores(after(0)), other.scores(after(0)))
    assert not np.array_equal(one.scores(after(0)), other.scores(after(0)) + 1e-9)
    picks = np.bincount([choose(one.scores(after(0)), after(0).unvisited) for _ in range(1400)], minlength=8)
    assert picks[0] == 0
    assert np.all(np.abs(picks[1:] - 200) < 5 * np.sqrt(200))


def test_what_has_been_visited_is_found_by_place() -> None:
    near = RING.copy()
    near[:, :3, 3] += 0.02
    assert visited_among(RING, near[[6, 1, 6]]) == (6, 1)
    near[:, :3, 3] += 1.0
    assert visited_among(RING, near) == ()
    with pytest.raises(ConfigError):
        Seen((), np.zeros((0, 4, 4)), RING, (), SMALL)


@pytest.mark.parametrize(
    "policy",
    [RandomPolicy(np.random.default_rng(0)), UniformPolicy(), FarthestPolicy(), OnBelief(CovariancePolicy(POSE_SIGMA), CAMERA)],
)
def test_all_of_them_are_general_policies(policy: ViewPolicy) -> None:
    assert isinstance(policy, ViewPolicy)
    assert policy.name
    assert policy.scores(after(0)).shape == (8,)


def ball(view: np.ndarray) -> Scan:
    directions, radius = SMALL.directions(), 0.3
    centre = -view[:3, :3].T @ view[:3, 3]
    along = directions @ centre
    inside = along**2 - centre @ centre + radius**2
    ranges = np.where(inside > 0, along - np.sqrt(np.maximum(inside, 0)), np.nan)
    return Scan.from_range(ranges, SMALL, camera_to_world=view)


LATTICE = Lattice(np.full(3, -0.5), 0.1, (10, 10, 10))


def test_a_volumetric_policy_is_its_metric_on_the_grid_of_the_scans() -> None:
    scans = tuple(ball(RING[view]) for view in (0, 3))
    grid = VoxelGrid.empty(LATTICE, CERTAIN).plus([evidence(LATTICE, scan, empty_is_free=True, stride=2) for scan in scans])
    mapper = Mapper(LATTICE, model=CERTAIN, empty_is_free=True, stride=2, step=2)
    seen = after(0, 3, scans=scans)
    np.testing.assert_array_equal(mapper.grid(scans).log_odds, grid.log_odds)
    for metric in VOLUMETRIC.values():
        policy = VolumetricPolicy(metric, mapper)
        assert policy.name == metric.name
        assert isinstance(policy, ViewPolicy)
        fresh = VolumetricPolicy(metric, Mapper(LATTICE, model=CERTAIN, empty_is_free=True, stride=2, step=2))
        np.testing.assert_array_equal(policy.scores(seen), fresh.scores(seen))


def test_what_a_mapper_remembers_changes_no_answer() -> None:
    scans = tuple(ball(RING[view]) for view in (0, 3, 5))
    shared = VolumetricPolicy(OcclusionAware(), Mapper(LATTICE, step=2))
    questions = [after(0, scans=scans[:1]), after(0, 3, scans=scans[:2]), after(3, 5, scans=scans[1:]), after(0, scans=scans[:1])]
    questions.append(Seen(scans[:1], RING[:1], RING[2:5], (), SMALL))
    for seen in [*questions, *questions]:
        alone = VolumetricPolicy(OcclusionAware(), Mapper(LATTICE, step=2))
        np.testing.assert_array_equal(shared.scores(seen), alone.scores(seen))


def test_a_volumetric_policy_looks_at_the_side_that_was_not_seen() -> None:
    for view in (0, 3):
        seen = after(view, scans=(ball(RING[view]),))
        for name in ("rear_side_voxel", "rear_side_entropy", "proximity_count"):
            best = choose(VolumetricPolicy(VOLUMETRIC[name], Mapper(LATTICE, step=2)).scores(seen), seen.unvisited)
            assert best is not None
            assert min((best - view) % 8, (view - best) % 8) >= 2, name


def test_a_scan_without_a_pose_is_refused_by_name() -> None:
    scan = Scan(points=ball(RING[0]).points, source="left.ply")
    with pytest.raises(ScanError, match=r"left\.ply"):
        VolumetricPolicy(OcclusionAware(), Mapper(LATTICE)).scores(after(0, scans=(scan,)))


def test_a_general_policy_decides_about_a_box_whatever_its_unit() -> None:
    """1 % apart, which next_view would call equal: the higher score still wins, and of equal ones the lower index."""
    scan = scan_of(BOX, view=corner_view(BOX), rng=np.random.default_rng(0)).posed(corner_view(BOX))
    for factor in (1e-9, 1.0, 1e6):
        for scores, best in (
            ((1.0, 0.99, 0.98, 0.97, 1.001, 0.98, 0.99, 0.5), 4),
            ((0.1, 0.2, 0.9, 0.1, 0.1, 0.9, 0.1, 0.1), 2),
            ((0.1, 0.2, np.nan, 0.1, 0.1, 0.9, 0.1, 0.1), 5),
        ):
            policy = OnScans(Liking(tuple(factor * score for score in scores)), (scan,), CAMERA.intrinsics)
            assert isinstance(policy, Policy)
            result = next_view(scan, policy=policy, camera=CAMERA)
            assert (result.best, result.policy) == (best, "liking")


def test_a_general_policy_is_shown_the_world_in_which_the_scans_lie() -> None:
    first = corner_view(BOX)
    scan = scan_of(BOX, view=first, rng=np.random.default_rng(0)).posed(first)
    seen: list[Seen] = []

    @dataclass(frozen=True)
    class Watching:
        name: str = "watching"

        def scores(self, there: Seen) -> np.ndarray:
            seen.append(there)
            return np.arange(len(there.candidates), dtype=float)

    result = next_view(scan, policy=OnScans(Watching(), (scan,), CAMERA.intrinsics), camera=CAMERA)
    (shown,) = seen
    np.testing.assert_allclose(shown.stands, first[None], atol=1e-12)
    expected = [first @ candidate.camera_to_current for candidate in result.candidates]
    np.testing.assert_allclose(shown.candidates, expected, atol=1e-12)
    assert shown.visited == (0,)


def test_the_model_plays_as_a_general_policy() -> None:
    """Its scores are those that next_view gives the same candidates."""
    first = corner_view(BOX)
    scan = scan_of(BOX, view=first, rng=np.random.default_rng(0)).posed(first)
    plan = next_view(measure(scan, camera=CAMERA), camera=CAMERA)
    there = np.stack([first @ candidate.camera_to_current for candidate in plan.candidates])
    seen = Seen((scan,), first[None], there, (0,), CAMERA.intrinsics)
    scores = OnBelief(CovariancePolicy(POSE_SIGMA), CAMERA).scores(seen)
    np.testing.assert_allclose(scores, [candidate.assessment.score for candidate in plan.candidates], atol=1e-6)


def test_where_nothing_can_be_measured_the_model_has_no_opinion() -> None:
    assert np.all(np.isnan(OnBelief(CovariancePolicy(POSE_SIGMA), CAMERA).scores(after(0))))
    floating = ball(look_at(np.array([1.0, 0.2, 0.3]), np.zeros(3), np.array([0, 0, 1.0])))
    assert np.all(np.isnan(OnBelief(CovariancePolicy(POSE_SIGMA), CAMERA).scores(after(0, scans=(floating,)))))


def test_policies_do_not_care_where_the_world_is() -> None:
    motion = pose(look_at(np.array([1.0, 2.0, 3.0]), np.zeros(3), np.array([0, 0, 1.0]))[:3, :3], np.array([4.0, -1.0, 2.0]))
    for policy in (UniformPolicy(), FarthestPolicy()):
        np.testing.assert_allclose(policy.scores(after(0, 3)), policy.scores(after(0, 3, candidates=motion @ RING)), atol=1e-9)


def test_an_assessment_by_places_has_no_outlook() -> None:
    scan = scan_of(BOX, view=corner_view(BOX), rng=np.random.default_rng(0)).posed(corner_view(BOX))
    belief_policy = OnScans(Liking((1.0, 3.0, 2.0)), (scan,), CAMERA.intrinsics)
    assessed = belief_policy.assess(None, np.stack([np.eye(4)] * 3), 0.05)  # type: ignore[arg-type]
    assert [(each.score, each.outlook, each.prediction) for each in assessed] == [
        (-2, None, None),
        (0, None, None),
        (-1, None, None),
    ]

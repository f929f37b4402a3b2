"""Coverage: every fast path gives what counting distance by distance gives, to the last bit."""

import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.coverage import covered_by, near, walk
from viewgain.compiled import compiled
from viewgain.errors import ConfigError, MissingExtraError, ScanError
from viewgain.gain import (
    PAPER,
    PCNBV,
    Cover,
    CoverageLabels,
    CoverageProtocol,
    Rule,
    Search,
    cover,
    coverage_auc,
    coverage_labels,
    greedy_labels,
    greedy_union,
    labels_from,
    model_clouds,
    normalised,
    packed,
    size,
    surface_samples,
    unpacked,
)
from viewgain.gain._near import near_any, near_marks, near_pairs
from viewgain.meshes import MeshFolder

SEEDS = st.integers(0, 2**32 - 1)
SEARCHES: list[Search] = ["numba", "scipy"]
Problem: TypeAlias = Callable[[int, int], tuple[list[np.ndarray], np.ndarray, float]]
SMALL = CoverageProtocol(name="small", rig="pcnbv16", steps=3, surface_points=400, reach=0.05, width=64, height=48, focal=47.6)


def lattice(rng: np.random.Generator, count: int, *, span: int = 6, rough: float = 0.0) -> np.ndarray:
    """Return points at multiples of 0.1: many distances are equal to the reach up to rounding, which is where methods differ."""
    return rng.integers(0, span, (count, 3)) * 0.1 + rough * rng.normal(size=(count, 3))


def problem(seed: int, views: int = 4) -> tuple[list[np.ndarray], np.ndarray, float]:
    rng = np.random.default_rng(seed)
    rough = float(rng.choice([0.0, 1e-16, 1e-3]))
    clouds = [lattice(rng, int(rng.integers(0, 25)), rough=rough) for _ in range(views)]
    reach = float(rng.choice([0.1, 0.1 * np.sqrt(2), 0.2, 0.07, 3.0]))
    return clouds, lattice(rng, int(rng.integers(1, 40)), rough=rough), reach


@pytest.mark.parametrize("search", SEARCHES)
@given(seed=SEEDS)
def test_near_pairs_are_those_of_the_whole_table(search: Search, seed: int) -> None:
    (points, others, *_), _, reach = problem(seed)
    table = near(points, others, reach)
    pairs = near_pairs(points, others, reach, search=search)
    rows = [sorted(pairs.ids[pairs.starts[k] : pairs.starts[k + 1]].tolist()) for k in range(len(points))]
    assert rows == [np.flatnonzero(row).tolist() for row in table]
    chosen = np.flatnonzero(np.random.default_rng(seed).random(len(points)) < 0.6)
    np.testing.assert_array_equal(near_any(points, chosen, others, reach, search=search), table.any(axis=1)[chosen])
    np.testing.assert_array_equal(np.sort(pairs.of(chosen)), np.sort(np.concatenate([[], *(rows[k] for k in chosen)])))


@pytest.mark.parametrize("search", SEARCHES)
@given(seed=SEEDS)
def test_dense_clouds_too(search: Search, seed: int) -> None:
    # Many points within one reach, as in an image: here most are settled by the small cube they lie in.
    rng = np.random.default_rng(seed)
    patch = rng.random((300, 3)) * [1.0, 1.0, 0.02]
    points, others = patch + rng.normal(0, 0.002, patch.shape), patch[rng.random(300) < rng.random()]
    reach = float(rng.uniform(0.02, 0.2))
    distances = ((points[:, None] - others[None]) ** 2).sum(axis=2)
    clear = np.all(np.abs(distances / reach**2 - 1) > 1e-9, axis=1)  # here sums may be rounded another way
    touched = near_any(points, np.flatnonzero(clear), others, reach, search=search)
    np.testing.assert_array_equal(touched, np.any(distances < reach**2, axis=1)[clear])


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("rule", ["published", "union"])
@given(seed=SEEDS)
def test_labels_are_those_of_the_accumulated_cloud(search: Search, rule: str, seed: int) -> None:
    clouds, surface, reach = problem(seed)
    covered = cover(clouds, surface, reach, search=search)
    for view, cloud in enumerate(clouds):
        np.testing.assert_array_equal(covered.mask(view), covered_by(cloud, surface, reach))
    labels = greedy_labels(covered, first=seed % 4, steps=4, rule=rule)
    twin = walk(clouds, surface, reach, first=seed % 4, steps=4, rule=rule)
    assert labels.order.tolist() == twin.order
    assert labels.gains_published.tolist() == twin.gains_published
    assert labels.gains_union.tolist() == twin.gains_union
    np.testing.assert_allclose(labels.coverage_published, twin.coverage_published, rtol=1e-14)  # a sum of shares, a share of sums
    assert labels.coverage_union.tolist() == twin.coverage_union


@given(seed=SEEDS, wander=st.floats(0, 1), rule=st.sampled_from(["published", "union"]))
def test_labels_of_a_sequence_that_strays_are_those_of_its_own_order(seed: int, wander: float, rule: Rule) -> None:
    clouds, surface, reach = problem(seed)
    covered = cover(clouds, surface, reach)
    rng = np.random.default_rng(seed)
    labels = greedy_labels(covered, first=seed % 4, steps=5, rule=rule, wander=wander, rng=rng)
    order = labels.order.tolist()
    twin = walk(clouds, surface, reach, first=seed % 4, steps=5, rule=rule, order=order)
    assert labels.gains_published.tolist() == twin.gains_published
    assert labels.gains_union.tolist() == twin.gains_union
    assert labels.coverage_union.tolist() == twin.coverage_union
    for step, (view, gains) in enumerate(zip(order, labels.gains(rule), strict=True)):
        assert view == np.argmax(gains) or view not in (seed % 4, *order[:step])


@given(seed=SEEDS)
def test_a_sequence_strays_as_often_as_it_is_asked_to(seed: int) -> None:
    clouds, surface, reach = problem(seed)
    covered = cover(clouds, surface, reach)
    straight = greedy_labels(covered, first=0, steps=3, wander=0.0, rng=np.random.default_rng(seed))
    same_labels(straight, greedy_labels(covered, first=0, steps=3))
    lost = greedy_labels(covered, first=0, steps=len(clouds) - 1, wander=1.0, rng=np.random.default_rng(seed))
    assert sorted(lost.order.tolist()) == list(range(1, len(clouds)))  # all others, each once


def dense(seed: int, views: int) -> tuple[list[np.ndarray], np.ndarray, float]:
    """Return views of a wavy sheet, each of a part of it: here whole cubes of points are settled at once."""
    rng = np.random.default_rng(seed)
    sheet = rng.random((300, 3)) * [1.0, 1.0, 0.0]
    sheet[:, 2] = 0.1 * np.sin(7 * sheet[:, 0])
    clouds = [sheet[sheet @ rng.normal(size=3) > rng.normal(0, 0.5)] + rng.normal(0, 0.002, 3) for _ in range(views)]
    return clouds, sheet[:90], float(rng.uniform(0.02, 0.3))


def same_labels(together: CoverageLabels, alone: CoverageLabels) -> None:
    for field in fields(CoverageLabels):
        one, other = np.asarray(getattr(together, field.name)), np.asarray(getattr(alone, field.name))
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("make", [problem, dense])
@given(seed=SEEDS, views=st.sampled_from([4, 5, 16, 33, 64]), steps=st.sampled_from([1, 1, 2]))
@settings(max_examples=15)
def test_labels_of_many_starts_are_those_of_each(search: Search, make: Problem, seed: int, views: int, steps: int) -> None:
    clouds, surface, reach = make(seed, views)
    covered = cover(clouds, surface, reach, search=search)
    starts = np.random.default_rng(seed).permutation(views)[: max(4, views // 2)].tolist()
    rule: Rule = "union" if seed % 3 == 0 else "published"
    for together in labels_from(covered, starts, steps=steps, rule=rule):
        same_labels(together, greedy_labels(covered, first=together.first, steps=steps, rule=rule))


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize(
    "clouds",
    [
        [np.zeros((0, 3))] * 5,
        [np.zeros((0, 3)), np.zeros((1, 3)), *[np.zeros((0, 3))] * 2],
        [np.zeros((7, 3))] * 33,
        [np.full((2, 3), 0.1 * view) for view in range(65)],
        [lattice(np.random.default_rng(1), 40)] * 64,
        [np.array([[x, y, y]]) for x, y in ((0.0, 0.0), (0.05, 0.0), (1e6, 0.0), (1e6, 0.05))],  # the cubes grow
    ],
    ids=["nothing", "one point", "duplicates", "more views than bits", "equal views", "far apart"],
)
def test_labels_of_many_starts_at_the_edges(search: Search, clouds: list[np.ndarray]) -> None:
    covered = cover(clouds, lattice(np.random.default_rng(0), 30), 0.1, search=search)
    labels = labels_from(covered, range(covered.views), steps=1)
    assert [each.first for each in labels] == list(range(covered.views))
    for each in labels:
        same_labels(each, greedy_labels(covered, first=each.first, steps=1))


def test_labels_of_no_start_are_none() -> None:
    assert labels_from(bad_cover(), [], steps=1) == ()


@pytest.mark.parametrize("search", SEARCHES)
@given(seed=SEEDS)
def test_near_marks_are_those_of_the_whole_table(search: Search, seed: int) -> None:
    clouds, _, reach = problem(seed)
    points, marks = (
        np.concatenate(clouds),
        np.repeat(np.uint64(1) << np.arange(4, dtype=np.uint64), [len(each) for each in clouds]),
    )
    wanted = [int(np.bitwise_or.reduce(marks[row])) for row in near(points, points, reach)]
    assert near_marks(points, marks, reach, search=search).tolist() == wanted


@given(seed=SEEDS)
def test_bit_packed_greedy_is_the_union_walk(seed: int) -> None:
    clouds, surface, reach = problem(seed)
    covered = cover(clouds, surface, reach)
    fast = greedy_union(covered.masks, len(surface), first=1, steps=5)
    labels = greedy_labels(covered, first=1, steps=5, rule="union")
    assert fast.order.tolist() == labels.order.tolist()
    assert fast.gains.tolist() == labels.gains_union.tolist()
    assert fast.coverage.tolist() == labels.coverage_union.tolist()


def random_masks(seed: int, views: int = 8, samples: int = 150) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.random((views, samples)) < rng.random((views, 1))


@given(seed=SEEDS)
def test_coverage_grows_and_gains_shrink(seed: int) -> None:
    walked = greedy_union(packed(random_masks(seed)), 150, first=seed % 8, steps=7)
    assert np.all(np.diff(walked.coverage) >= 0)
    assert walked.coverage[-1] <= 1
    assert np.all(np.diff(walked.gains, axis=0) <= 0)  # a union is submodular: what is known only makes others less worth
    np.testing.assert_array_equal(walked.gains[0, seed % 8], 0)


@given(seed=SEEDS)
def test_a_point_more_never_lowers_coverage(seed: int) -> None:
    clouds, surface, reach = problem(seed)
    more = [np.concatenate([cloud, lattice(np.random.default_rng(seed + 1), 3)]) for cloud in clouds]
    before, after = cover(clouds, surface, reach), cover(more, surface, reach)
    assert not np.any(before.masks & ~after.masks)


@given(seed=SEEDS, count=st.integers(0, 200))
def test_bits_come_back(seed: int, count: int) -> None:
    masks = random_masks(seed, 3, count) if count else np.zeros((3, 0), dtype=bool)
    bits = packed(masks)
    assert bits.dtype == np.uint64
    assert bits.shape == (3, -(-count // 64))
    np.testing.assert_array_equal(unpacked(bits, count), masks)
    np.testing.assert_array_equal(size(bits), masks.sum(axis=1))


@pytest.mark.parametrize("search", SEARCHES)
def test_a_point_at_the_reach_covers_nothing(search: Search) -> None:
    surface = np.array([[0.5, 0, 0], [np.nextafter(0.5, 0), 0, 0], [-0.5, 0, 0]])
    assert cover([np.zeros((1, 3))], surface, 0.5, search=search).mask(0).tolist() == [False, True, False]
    queries = np.array([[0.1, 0, 0], [0.5, 0, 0], [0.45, 0, 0], [0, -0.5, 0]])
    assert near_any(queries, np.arange(4), np.zeros((1, 3)), 0.5, search=search).tolist() == [True, False, True, False]


def test_the_two_rules_by_hand() -> None:
    # Samples at 0, 1, 2, 3 on a line, the reach a little over 1. View 0 has a point at 0, view 1 at 1 and 2.5, view 2 at 1.5.
    surface = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [3.0, 0, 0]])
    clouds = [np.array([[x, 0.0, 0.0] for x in xs]) for xs in ([0.0], [1.0, 2.5], [1.5])]
    labels = greedy_labels(cover(clouds, surface, 1.1), first=0, steps=2)
    # View 1's point at 1 is near 0, so it is not new and its sample 2 counts only by way of 2.5. View 2's point is new and counts
    # sample 1 though it is covered already: that is the published rule.
    assert labels.gains_published[0].tolist() == [0, 0.5, 0.5]
    assert labels.gains_union[0].tolist() == [0, 0.5, 0.25]
    assert labels.order.tolist() == [1, 0]
    assert labels.coverage_published.tolist() == [0.5, 1.0, 1.0]
    assert labels.gains_published[1].tolist() == [0, 0, 0]  # view 2's point is near the one at 2.5


def test_published_coverage_counts_surface_twice() -> None:
    surface = np.array([[0.0, 0, 0]])
    clouds = [np.array([[-0.9, 0.0, 0.0]]), np.array([[0.9, 0.0, 0.0]])]
    labels = greedy_labels(cover(clouds, surface, 1.0), first=0, steps=1)
    assert labels.coverage_published.tolist() == [1.0, 2.0]
    assert labels.coverage_union.tolist() == [1.0, 1.0]


def test_published_gain_leaves_out_what_known_surroundings_cover() -> None:
    # View 1's point is within reach of view 0's, so it is not new, though it covers a sample that view 0 does not.
    surface = np.array([[0.0, 0, 0], [1.9, 0, 0]])
    labels = greedy_labels(cover([np.zeros((1, 3)), np.array([[0.95, 0, 0]])], surface, 1.0), first=0, steps=1)
    assert labels.gains_published.tolist() == [[0, 0]]
    assert labels.gains_union.tolist() == [[0, 0.5]]


def test_without_the_extra_scipy_searches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    compiled.cache_clear()
    try:
        with pytest.raises(MissingExtraError, match=r"viewgain\[data\]"):
            bad_cover(search="numba")
        assert bad_cover().mask(0).tolist() == [True]
        assert bad_cover(search="scipy").coverage.tolist() == [1]
    finally:
        compiled.cache_clear()


def test_auc_by_hand() -> None:
    assert coverage_auc(np.array([1.0])) == 0.5
    assert coverage_auc(np.array([0.2, 0.6, 1.0])) == pytest.approx((0.2 + 0.6 + 0.5) / 3)
    ten = np.linspace(0.1, 1.0, 10)
    assert coverage_auc(ten) == pytest.approx(np.trapezoid([0, *ten]) / 10)


@pytest.fixture(scope="module")
def chair(request: pytest.FixtureRequest) -> tuple[list[np.ndarray], np.ndarray]:
    folder: Path = request.getfixturevalue("data_dir")
    mesh = MeshFolder.open(folder / "meshes").only("chair_stool")[0].load()
    return model_clouds(mesh, SMALL), surface_samples(normalised(mesh, SMALL), 400, rng=np.random.default_rng(5))


def test_a_real_mesh_by_both_searches_and_by_brute_force(chair: tuple[list[np.ndarray], np.ndarray], data_dir: Path) -> None:
    clouds, surface = chair
    twin = walk(clouds[:5], surface, SMALL.reach, first=2, steps=3, rule="published")
    for search in SEARCHES:
        labels = greedy_labels(cover(clouds[:5], surface, SMALL.reach, search=search), first=2, steps=3)
        assert labels.order.tolist() == twin.order
        assert labels.gains_published.tolist() == twin.gains_published
        assert labels.gains_union.tolist() == twin.gains_union


def test_views_of_a_real_mesh_add_up(chair: tuple[list[np.ndarray], np.ndarray], data_dir: Path) -> None:
    clouds, surface = chair
    labels = coverage_labels(clouds, surface, SMALL, 3)
    assert labels.gains("published") is labels.gains_published
    assert labels.gains_published.shape == labels.gains_union.shape == (3, 16)
    assert 0.2 < labels.coverage_union[0] < labels.coverage_union[-1] <= 1


def test_one_cover_serves_every_start(chair: tuple[list[np.ndarray], np.ndarray], data_dir: Path) -> None:
    clouds, surface = chair
    covered = cover(clouds, surface, SMALL.reach)
    counts = covered.counts.copy()
    for first in range(16):
        once, again = greedy_labels(covered, first=first, steps=1), coverage_labels(clouds, surface, PAPER, first)
        assert once.gains_published.shape == again.gains_published.shape == (1, 16)
        assert once.gains_published[0, first] == 0
    np.testing.assert_array_equal(covered.counts, counts)


def test_the_protocols_are_the_public_ones() -> None:
    assert (PCNBV.steps, PCNBV.rig, PAPER.steps, PAPER.rig) == (10, "pcnbv33", 1, "pcnbv16")
    assert PCNBV.reach**2 == pytest.approx(0.00005, rel=1e-15)
    assert (PCNBV.surface_points, PCNBV.width, PCNBV.height, PCNBV.focal, PCNBV.distance) == (16384, 640, 480, 476.0, 1.0)


def bad_cover(**changes: object) -> Cover:
    settings = {"clouds": [np.zeros((1, 3))], "surface": np.zeros((1, 3)), "reach": 1.0} | changes
    return cover(**settings)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({"reach": 0.0}, ConfigError),
        ({"reach": np.nan}, ConfigError),
        ({"clouds": []}, ScanError),
        ({"surface": np.zeros((0, 3))}, ScanError),
        ({"surface": np.zeros((4, 2))}, ScanError),
        ({"clouds": [np.full((2, 3), np.nan)]}, ScanError),
    ],
)
def test_nonsense_is_refused(changes: dict[str, object], kind: type[Exception]) -> None:
    with pytest.raises(kind, match="wanted"):
        bad_cover(**changes)


def test_starts_and_rules_are_checked() -> None:
    covered = bad_cover()
    rng, fine = np.random.default_rng(0), {"first": 0, "steps": 1}
    astray = [fine | wrong for wrong in ({"wander": 0.5}, {"wander": 1.5, "rng": rng}, {"wander": -0.5, "rng": rng})]
    for request in ({"first": 1, "steps": 1}, {"first": 0, "steps": 0}, fine | {"rule": "best"}, *astray):
        with pytest.raises(ConfigError, match="wanted"):
            greedy_labels(covered, **request)  # type: ignore[arg-type]
    for starts, steps, rule in (([0, 1, 0, 0], 1, "published"), ([0] * 4, 0, "published"), ([0] * 4, 1, "best")):
        with pytest.raises(ConfigError, match="wanted"):
            labels_from(covered, starts, steps=steps, rule=rule)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="wanted"):
        coverage_auc(np.zeros(0))
    with pytest.raises(ConfigError, match="steps"):
        CoverageProtocol(name="none", rig="pcnbv33", steps=0)
    with pytest.raises(ConfigError, match="reach"):
        CoverageProtocol(name="none", rig="pcnbv33", steps=1, reach=-1.0)


def test_views_that_see_nothing_cover_nothing() -> None:
    labels = greedy_labels(cover([np.zeros((0, 3))] * 3, np.zeros((5, 3)), 0.1), first=2, steps=2)
    assert not labels.gains_published.any()
    assert labels.order.tolist() == [0, 0]
    assert labels.coverage_union.tolist() == [0, 0, 0]


@pytest.mark.parametrize("search", SEARCHES)
def test_far_flung_points_cost_no_memory(search: Search) -> None:
    # A grid of cubes as small as the reach would have 1e27 of them.
    surface = np.array([[0.0, 0, 0], [1e9, 1e9, 1e9]])
    covered = cover([np.array([[0.5, 0.0, 0.0], [-1e12, 0, 0]]), np.array([[1e9, 1e9, 1e9]])], surface, 1.0, search=search)
    assert [covered.mask(view).tolist() for view in range(2)] == [[True, False], [False, True]]
    labels = greedy_labels(covered, first=0, steps=1)
    assert labels.gains_published.tolist() == [[0, 0.5]]
    near = np.array([[0.9, 0, 0], [1.1, 0, 0], [-1e12, 0.5, 0], [1e12, 0, 0]])
    assert near_any(near, np.arange(4), np.array([[0.0, 0, 0], [-1e12, 0, 0]]), 1.0, search=search).tolist() == [
        True,
        False,
        True,
        False,
    ]

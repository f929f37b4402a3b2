"""What a sample says must agree with itself and with the world it was made in."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.datasets.engines import Inline
from viewgain.datasets import BoxSettings, CoverageSettings, Dataset, PointRules, Recipe, Sample, build, plan_of, recipe
from viewgain.datasets._mesh_units import mesh_of
from viewgain.datasets._seeds import SURFACE, generator
from viewgain.errors import ConfigError
from viewgain.gain import COVERAGE_PROTOCOLS, coverage_labels, model_clouds, surface_samples
from viewgain.geometry import inverse, transform
from viewgain.rigs import Target, poses, rig
from viewgain.simulate import EFFECTS


def each_kind(request: pytest.FixtureRequest, name: str) -> Dataset:
    return request.getfixturevalue(name)  # type: ignore[no-any-return]


KINDS = ["boxes", "coverage", "meshes", "random_boxes"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_array_over_candidates_has_one_entry_each_and_the_present_view_first(
    kind: str, request: pytest.FixtureRequest
) -> None:
    for sample in each_kind(request, kind):
        count = len(sample.candidates)
        assert sample.candidates.shape == (count, 4, 4)
        assert sample.state.shape == sample.reachable.shape == (count,)
        assert all(scores.shape == (count,) for scores in sample.targets.values())
        assert 0 <= sample.view < count
        assert sample.state[0]
        assert sample.state.sum() == sample.step + 1
        assert all(scores[0] == 0 for scores in sample.targets.values())  # where it stands there is nothing to gain
        # The present view is where the camera should have been sent to: jitter moves it by centimetres and degrees, no more.
        assert np.linalg.norm(sample.candidates[0, :3, 3]) < 0.35
        assert sample.candidates[0, 2, 2] > 0.95


@pytest.mark.parametrize("kind", KINDS)
def test_candidates_are_the_stations_of_one_rig_whatever_camera_they_are_told_from(
    kind: str, request: pytest.FixtureRequest
) -> None:
    """From any sample of an object the candidates, in rig order and in the object's frame, are the same poses."""
    stations: dict[int, np.ndarray] = {}
    for sample in each_kind(request, kind):
        in_object = inverse(sample.object_to_camera.astype(float)) @ sample.candidates
        unrolled = np.roll(in_object, sample.view, axis=0)
        np.testing.assert_allclose(unrolled, stations.setdefault(sample.object, unrolled), atol=2e-5)
    assert len(stations) == 2


def test_box_candidates_are_the_papers_four_positions(boxes: Dataset) -> None:
    for sample in boxes:
        views = poses(rig("paper4"), Target(np.eye(4), sample.dims.astype(float)), elevation=0.6, distance=1.2)
        in_object = inverse(sample.object_to_camera.astype(float)) @ sample.candidates
        np.testing.assert_allclose(np.roll(in_object, sample.view, axis=0), views, atol=2e-5)


def test_coverage_samples_hold_the_labels_that_the_clouds_give_when_asked_again(coverage: Dataset) -> None:
    plan = plan_of(recipe("coverage_pcnbv_tiny"))
    protocol = COVERAGE_PROTOCOLS["pcnbv"]
    unit = plan.units[1]
    mesh = mesh_of(unit, 0)
    surface = surface_samples(mesh.normalised(), 16384, rng=generator(0, (1, SURFACE, 0, 0)))
    clouds = model_clouds(mesh, protocol)
    samples = [sample for sample in coverage if sample.object == 1]
    labels = coverage_labels(clouds, surface, protocol, samples[0].view)
    assert [sample.view for sample in samples] == [labels.first, *labels.order[:-1].tolist()]
    for step, sample in enumerate(samples):
        for name, gains in (("gain_published", labels.gains_published), ("gain_union", labels.gains_union)):
            np.testing.assert_array_equal(sample.in_rig_order(sample.targets[name]), gains[step].astype(np.float32))
        assert sample.coverage == np.float32(labels.coverage_union[step])
        visited = np.flatnonzero(sample.in_rig_order(sample.state)).tolist()
        assert visited == sorted({labels.first, *labels.order[:step].tolist()})
        seen = np.concatenate([clouds[view] for view in visited])
        gap, _ = KDTree(seen).query(sample.points)
        assert gap.max() < 2e-5  # half a step of the stored numbers


def test_samples_of_sequences_that_stray_hold_what_each_view_would_add_to_their_own(tmp_path: Path) -> None:
    tiny = recipe("coverage_pcnbv_tiny")
    assert isinstance(tiny.content, CoverageSettings)
    astray = replace(tiny, content=replace(tiny.content, starts=2, steps=4, wander=0.9))
    build(plan_of(astray), tmp_path / "data", engine=Inline())
    data = Dataset(tmp_path / "data")
    assert [sample.step for sample in data] == [0, 1, 2, 3] * 4
    best = 0
    for before, after in pairwise(data):
        union = before.in_rig_order(before.targets["gain_union"])
        if after.step:
            assert after.coverage == pytest.approx(
                before.coverage + union[after.view], abs=1e-6
            )  # both are stored in single precision
            best += int(before.in_rig_order(before.targets["gain_published"]).argmax() == after.view)
        masks = np.unpackbits(data.masks(before.object), axis=1).astype(bool)
        known = masks[np.flatnonzero(before.in_rig_order(before.state))].any(axis=0)
        np.testing.assert_allclose(union, (masks & ~known).sum(axis=1) / 16384, atol=1e-7)
    assert best < 8  # of 12 steps; about one in ten is not drawn


def test_masks_give_the_union_gain_without_rays(coverage: Dataset) -> None:
    for sample in coverage:
        covered = np.unpackbits(coverage.masks(sample.object), axis=1)[:, :].astype(bool)
        known = covered[np.flatnonzero(sample.in_rig_order(sample.state))].any(axis=0)
        gains = (covered & ~known).sum(axis=1) / 16384
        np.testing.assert_allclose(sample.in_rig_order(sample.targets["gain_union"]), gains, atol=1e-7)
        assert sample.coverage == pytest.approx(known.sum() / 16384)


@pytest.mark.parametrize("kind", KINDS)
def test_points_go_from_frame_to_frame_and_back(kind: str, request: pytest.FixtureRequest) -> None:
    for sample in each_kind(request, kind):
        other = sample.in_frame("object" if sample.frame == "camera" else "camera")
        assert other.frame != sample.frame
        np.testing.assert_allclose(other.in_frame(sample.frame).points, sample.points, atol=5e-6)
        in_camera = sample.in_frame("camera").points
        assert np.all(in_camera[:, 2] > 0) or sample.step > 0  # in front of the camera; of later steps, other cameras saw some


def test_without_the_pose_of_the_object_there_is_no_other_frame(boxes: Dataset) -> None:
    lost = replace(boxes[0], object_to_camera=np.full((4, 4), np.nan))
    assert lost.in_frame("camera") is lost
    with pytest.raises(ConfigError, match="no pose of object 0"):
        lost.in_frame("object")


PERFECT = Recipe(
    name="perfect",
    makes="exact scans",
    points=PointRules(cap=3000),
    content=BoxSettings(
        sizes=((0.4, 0.3, 0.2), (0.3, 0.2, 0.5)), captures=2, captures_per_unit=2, train_captures=1, test_boxes=1,
        without=EFFECTS, yaw_deg=(0, 360),
    ),
)  # fmt: skip


def distance_to_box_or_floor(sample: Sample) -> np.ndarray:
    """Return how far each point lies from the nearest of the box's five faces and the floor, metres."""
    x, y, z = transform(inverse(sample.object_to_camera.astype(float)), sample.points.astype(float)).T
    half_x, half_y, high = sample.dims[0] / 2, sample.dims[1] / 2, sample.dims[2]
    outside = np.maximum.reduce([np.abs(x) - half_x, np.abs(y) - half_y, z - high, -z])
    box = np.where(outside > 0, np.inf, -outside)
    near = np.linalg.norm(np.maximum([np.abs(x) - half_x, np.abs(y) - half_y, z - high], 0), axis=0)
    return np.minimum.reduce([np.abs(z), box, np.where(outside > 0, near, np.inf)])


def test_points_of_a_perfect_camera_lie_on_the_true_box_and_floor(tmp_path: Path) -> None:
    build(plan_of(PERFECT), tmp_path, engine=Inline())
    data = Dataset(tmp_path)
    for sample in data:
        assert len(sample.points) == 3000
        assert distance_to_box_or_floor(sample).max() < 1e-4
    moved = replace(data[0], dims=data[0].dims + np.float32(0.02))
    assert distance_to_box_or_floor(moved).max() > 0.005  # the measure can tell


def test_a_bit_of_a_sample_depends_on_no_grouping(tmp_path: Path) -> None:
    """Other units of work, other shards: the same samples in the same order."""
    build(plan_of(PERFECT), tmp_path / "a", engine=Inline())
    other = replace(PERFECT, units_per_shard=3, content=replace(PERFECT.content, captures_per_unit=1))
    build(plan_of(other), tmp_path / "b", engine=Inline())
    a, b = Dataset(tmp_path / "a"), Dataset(tmp_path / "b")
    assert len(a) == len(b) == 16
    assert len(a.manifest.shards) != len(b.manifest.shards)
    for one, two in zip(a, b, strict=True):
        np.testing.assert_array_equal(one.points, two.points)
        np.testing.assert_array_equal(one.candidates, two.candidates)
        assert one.seed == two.seed


def test_the_published_division_shares_boxes_and_the_other_does_not(boxes: Dataset) -> None:
    objects = boxes.column("object")
    for split, shared in (("same_box", True), ("other_box", False)):
        train, test = boxes.part(split, "train"), boxes.part(split, "test")
        assert sorted([*train, *test]) == list(range(len(boxes)))
        assert bool(set(objects[train]) & set(objects[test])) == shared
    assert set(boxes.column("capture")[boxes.part("same_box", "test")]) == {2}


def test_categories_stay_together_in_the_stricter_division(meshes: Dataset) -> None:
    categories = meshes.column("category")
    train, test = meshes.part("other_category", "train"), meshes.part("other_category", "test")
    assert len(train)
    assert len(test)
    assert not set(categories[train]) & set(categories[test])


def test_another_seed_makes_other_samples(boxes: Dataset, tmp_path: Path) -> None:
    build(plan_of(replace(recipe("boxes_paper_tiny"), seed=1)), tmp_path, engine=Inline())
    assert not np.array_equal(Dataset(tmp_path)[0].points[:50], boxes[0].points[:50])


def test_resampled_points_are_its_own_and_as_many_as_asked_for(boxes: Dataset) -> None:
    sample = boxes[5]
    for count in (10, 1024, 5000):
        drawn = sample.resampled(count, rng=np.random.default_rng(1)).points
        assert drawn.shape == (count, 3)
        known = {tuple(point) for point in sample.points.tolist()}
        assert {tuple(point) for point in drawn.tolist()} <= known
    few = sample.resampled(600, rng=np.random.default_rng(1)).points
    assert len(np.unique(few, axis=0)) == 600  # none twice where there are enough

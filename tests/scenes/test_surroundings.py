"""Random scenes: what they promise about numbers, places and sizes, and that a seed makes the same one."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from viewgain.box import Box
from viewgain.geometry import inverse, transform
from viewgain.scenes import Scene, SceneRanges, Surroundings, random_box, random_scene

FULL = Surroundings(boxes=(3, 5), clutter=(1, 3), walls=(1, 2), reflectivity=(0.2, 0.8))
SEEDS = range(40)


def scene_of(seed: int, surroundings: Surroundings = FULL) -> Scene:
    return random_scene(np.random.default_rng(seed), surroundings=surroundings)


def samples(box: Box, rng: np.random.Generator) -> NDArray[np.float64]:
    """Points in the inside of a box, world frame."""
    return transform(box.box_to_camera, (rng.random((2000, 3)) - [0.5, 0.5, 0.0]) * box.extents)


def inside(box: Box, points: NDArray[np.float64], margin: float = 1e-6) -> NDArray[np.bool_]:
    local = np.abs(transform(inverse(box.box_to_camera), points) - [0, 0, box.extents[2] / 2])
    return np.asarray(np.all(local < box.extents / 2 - margin, axis=1))


def test_nothing_is_added_by_default() -> None:
    scene, box = random_scene(np.random.default_rng(5)), random_box(np.random.default_rng(5))
    assert len(scene.boxes) == 1
    assert scene.meshes == ()
    assert len(scene.planes) == 1
    np.testing.assert_array_equal(scene.boxes[0].extents, box.extents)


@pytest.mark.parametrize("seed", [0, 7])
def test_the_same_seed_makes_the_same_scene(seed: int) -> None:
    first, again, other = scene_of(seed), scene_of(seed), scene_of(seed + 1)
    np.testing.assert_array_equal([b.extents for b in first.boxes], [b.extents for b in again.boxes])
    np.testing.assert_array_equal([m.area for m in first.meshes], [m.area for m in again.meshes])
    assert first.reflectivity == again.reflectivity != other.reflectivity


def test_counts_sizes_and_reflectivities_keep_to_their_bounds_and_use_them() -> None:
    counts, walls = set(), set()
    for seed in SEEDS:
        scene = scene_of(seed)
        counts.add(len(scene.boxes))
        walls.add(len(scene.planes) - 1)
        assert 1 <= len(scene.boxes) <= 5
        assert 0 <= len(scene.meshes) <= 3
        for mesh in scene.meshes:
            assert 0.15 / np.sqrt(2) <= np.linalg.norm(mesh.extents) <= 0.4 * np.sqrt(2)  # turned since it was scaled
            assert abs(mesh.bounds[0, 2]) < 1e-9
        assert all(0.2 <= value <= 0.8 for value in scene.reflectivity)
        assert len(scene.reflectivity) == len(scene.boxes) + len(scene.meshes) + len(scene.planes)
    assert counts >= {3, 4, 5}
    assert walls == {1, 2}


def test_no_box_is_inside_another() -> None:
    rng = np.random.default_rng(0)
    for seed in SEEDS:
        boxes = scene_of(seed).boxes
        for box in boxes:
            assert not any(inside(other, samples(box, rng)).any() for other in boxes if other is not box)


def test_stacked_boxes_stand_on_the_one_below_and_within_its_top() -> None:
    found = 0
    for seed in SEEDS:
        boxes = scene_of(seed, Surroundings(boxes=(3, 3), stacked=1.0)).boxes
        for lower, upper in pairwise(boxes):
            foot = transform(inverse(lower.box_to_camera), upper.corners()[:4])
            np.testing.assert_allclose(foot[:, 2], lower.extents[2], atol=1e-9)
            assert np.all(np.abs(foot[:, :2]) <= lower.extents[:2] / 2 + 1e-9)
            found += 1
    assert found == 2 * len(SEEDS)


def test_touching_boxes_share_a_side_of_the_first() -> None:
    found = 0
    for seed in SEEDS:
        first, *others = scene_of(seed, Surroundings(boxes=(2, 2), stacked=0.0, touching=1.0)).boxes
        for box in others:
            local = transform(inverse(first.box_to_camera), box.corners())
            low, high = local[:, :2].min(axis=0), local[:, :2].max(axis=0)
            gap = np.maximum(low - first.extents[:2] / 2, -first.extents[:2] / 2 - high)
            assert np.isclose(gap.max(), 0, atol=1e-9)
            assert gap.min() < 0  # beside the side, not only beside its line
            assert abs(box.corners()[:4, 2]).max() < 1e-9
            found += 1
    assert found == len(SEEDS)


def test_walls_stand_behind_everything() -> None:
    for seed in SEEDS:
        scene = scene_of(seed)
        points = np.concatenate([*[box.corners() for box in scene.boxes], *[mesh.vertices for mesh in scene.meshes]])
        for plane in scene.planes[1:]:
            assert plane.height(points).min() > -1e-6
            assert plane.normal[2] == 0
        if len(scene.planes) == 3:
            assert scene.planes[1].normal @ scene.planes[2].normal == pytest.approx(0, abs=1e-9)


def test_sizes_of_free_boxes_come_from_the_ranges() -> None:
    ranges = SceneRanges(extent=(0.2, 0.25))
    scene = random_scene(np.random.default_rng(1), ranges, Surroundings(boxes=(4, 4), stacked=0.0, touching=0.0))
    assert len(scene.boxes) > 1
    assert all(np.all((box.extents >= 0.2) & (box.extents <= 0.25)) for box in scene.boxes)

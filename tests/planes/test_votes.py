"""Pairs vote for the planes that are there, wherever the cloud stands, and a cell stands for what voted into it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.planes.clouds import seen_corner, three_faces
from viewgain.geometry import rotation_from_rotvec
from viewgain.planes import AS_PUBLISHED, MENDED
from viewgain.planes._cloud import Cloud
from viewgain.planes._cluster import cluster, same_plane
from viewgain.planes._draw import balance, draw_pairs, draw_references, first_in_tree, morton_codes
from viewgain.planes._votes import Hypotheses, elected, pair_votes, tangents, vote

DIMS = np.array([0.4, 0.3, 0.2])


@given(st.lists(st.floats(-2, 2), min_size=3, max_size=3), st.lists(st.floats(-1, 1), min_size=3, max_size=3))
def test_votes_stay_under_a_rigid_motion_but_for_where_the_angle_starts(turn: list[float], shift: list[float]) -> None:
    cloud, rng = three_faces(DIMS, seen_corner()), np.random.default_rng(0)
    rotation = rotation_from_rotvec(np.array(turn))
    moved = Cloud(cloud.points @ rotation.T + shift, cloud.normals @ rotation.T)
    references = rng.integers(len(cloud), size=20)
    partners = rng.integers(len(cloud), size=(20, 50))
    before, after = (pair_votes(c, references, partners, AS_PUBLISHED) for c in (cloud, moved))
    assert np.mean(before.orthogonal == after.orthogonal) > 0.99  # a pair at the very threshold may fall either way
    np.testing.assert_allclose(before.offsets, after.offsets, atol=1e-9)
    both = before.orthogonal & after.orthogonal
    turned = np.exp(1j * (before.angles - after.angles))
    for k in range(20):
        own = turned[k][both[k]]
        if len(own):
            # Within 0.8 degrees of -z the frame is that of -z itself.
            np.testing.assert_allclose(own, own[0], atol=0.03)


def test_tangents_are_an_orthonormal_frame_even_opposite_to_z() -> None:
    normals = np.random.default_rng(1).normal(size=(50, 3))
    normals = np.concatenate([normals / np.linalg.norm(normals, axis=1, keepdims=True), [[0, 0, -1.0]], [[0, 0, 1.0]]])
    frame = np.stack([*tangents(normals), normals], axis=1)
    np.testing.assert_allclose(frame @ frame.transpose(0, 2, 1), np.tile(np.eye(3), (52, 1, 1)), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(frame), 1, atol=1e-9)


def decoded(**switches: bool) -> tuple[float, float]:
    """Return the mean absolute error of the offsets, and their mean signed one, of what 300 references elect."""
    cloud, rng = three_faces(DIMS, seen_corner()), np.random.default_rng(2)
    settings = replace(AS_PUBLISHED, random_pairs=True, references=300, **switches)
    references = draw_references(cloud, settings, rng)
    votes = pair_votes(cloud, references, draw_pairs(cloud, references, settings, rng), settings)
    rows, _, offsets = elected(votes, settings)
    truth = np.where(votes.orthogonal, votes.offsets, np.nan)
    off = offsets - truth[rows, np.nanargmin(np.abs(truth[rows] - offsets[:, None]), axis=1)]
    return float(np.abs(off).mean()), float(off.mean())


def test_the_decode_is_unbiased_only_when_mended() -> None:
    assert decoded(unbiased_decode=True)[0] < 1e-9
    assert decoded()[0] > 0.01


@pytest.mark.parametrize("settings", [AS_PUBLISHED, MENDED], ids=["published", "mended"])
def test_ideal_faces_become_three_clusters(settings) -> None:
    cloud = three_faces(DIMS, seen_corner())
    settings = replace(settings, random_pairs=True, unbiased_decode=True, band=0.03)
    planes = cluster(vote(cloud, settings, np.random.default_rng(3)), settings)
    cosine = np.abs(planes.normals @ seen_corner()[:3, :3])
    assert len(planes.normals) == 3
    np.testing.assert_allclose(np.sort(cosine.max(axis=1)), 1, atol=1e-6)
    assert set(np.argmax(cosine, axis=1)) == {0, 1, 2}


@given(st.integers(0, 10**6), st.integers(1, 30))
def test_clusters_are_those_of_a_slow_union_find(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(count, 3)) * 0.1 + np.eye(3)[rng.integers(3, size=count)]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    anchors = rng.normal(size=(count, 3)) * 0.05
    planes = Hypotheses(normals, -np.sum(normals * anchors, axis=1), anchors, np.empty((0, 2), dtype=int))
    root = list(range(count))
    for i in range(count):
        for j in range(count):
            apart = abs(normals[i] @ anchors[j] + planes.offsets[i]), abs(normals[j] @ anchors[i] + planes.offsets[j])
            if normals[i] @ normals[j] > AS_PUBLISHED.parallel and max(apart) < AS_PUBLISHED.band:
                low, high = sorted((root[i], root[j]))
                root = [low if r == high else r for r in root]
    assert len(cluster(planes, AS_PUBLISHED).normals) == len(set(root))
    assert np.array_equal(same_plane(planes, AS_PUBLISHED), same_plane(planes, AS_PUBLISHED).T)


def test_first_in_tree_is_the_order_of_the_exclusive_or_of_all_paths() -> None:
    points = np.random.default_rng(4).normal(size=(500, 3))
    path = morton_codes(points)
    for reference, got in zip((0, 7, 99), first_in_tree(points, np.array([0, 7, 99]), 40), strict=True):
        assert set(path[got] ^ path[reference]) == set(np.sort(path ^ path[reference])[:40])


def test_the_published_partners_are_a_clump_and_the_drawn_ones_are_not() -> None:
    cloud, rng = three_faces(DIMS, seen_corner(), pitch=0.003), np.random.default_rng(5)
    references = rng.integers(len(cloud), size=50)
    spread = {
        name: np.linalg.norm(
            cloud.points[draw_pairs(cloud, references, settings, rng)] - cloud.points[references][:, None], axis=2
        ).mean()
        for name, settings in (("tree", AS_PUBLISHED), ("drawn", replace(AS_PUBLISHED, random_pairs=True)))
    }
    assert spread["tree"] < 0.5 * spread["drawn"]


def test_balance_gives_a_small_face_more_than_its_share() -> None:
    normals = np.concatenate([np.tile([0, 0, 1.0], (900, 1)), np.tile([1.0, 0, 0], (100, 1))])
    weight = balance(normals)
    assert weight.sum() == pytest.approx(1)
    assert weight[900:].sum() == pytest.approx(0.25)


def test_an_empty_cloud_votes_for_nothing() -> None:
    nothing = Cloud(np.empty((0, 3)), np.empty((0, 3)))
    assert len(cluster(vote(nothing, MENDED, np.random.default_rng(0)), MENDED).normals) == 0

"""Policies that ask for no box."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.scenes import MODELLED
from viewgain.camera import sensor
from viewgain.gain import VOLUMETRIC
from viewgain.geometry import inverse, transform
from viewgain.plan import ColumnsPolicy, Seen, ViewPolicy, WatchedPolicy
from viewgain.plan._any_shape import columns_under, unhidden
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

CAMERA = sensor("pico_flexx")
BOX = standing_box(np.array([0.45, 0.3, 0.3]), yaw=0.2)
RING = np.stack([orbit_pose(BOX.centre, k * np.pi / 4, np.deg2rad(35), 1.2) for k in range(8)])
POLICIES = (ColumnsPolicy(CAMERA), WatchedPolicy(VOLUMETRIC["rear_side_voxel"], CAMERA))


def seen_from(place: int, scene: Scene) -> Seen:
    scan = capture(scene, RING[place], CAMERA, rng=np.random.default_rng(place), effects=MODELLED)
    return Seen((scan,), RING[place : place + 1], RING, (place,), CAMERA.intrinsics)


@pytest.mark.parametrize("policy", POLICIES)
def test_they_want_to_see_the_other_side(policy: ViewPolicy) -> None:
    scores = policy.scores(seen_from(1, Scene((BOX,))))
    others = np.delete(np.arange(8), 1)
    assert others[np.argmax(scores[others])] in (4, 5, 6)
    assert scores[5] > scores[1]


@pytest.mark.parametrize("policy", POLICIES)
def test_they_have_no_opinion_where_nothing_stands(policy: ViewPolicy) -> None:
    seen = seen_from(1, Scene(()))
    assert np.isnan(policy.scores(seen)).all()
    assert np.isnan(policy.scores(Seen((), seen.stands, RING, (1,), CAMERA.intrinsics))).all()


def test_columns_stand_under_their_points() -> None:
    points = np.array([[0.1, 0.2, 0.3], [0.0, 0.0, 0.06]])
    columns = columns_under(points)
    assert np.allclose(columns[::2], [[0.1, 0.2, z] for z in (0.0, 0.1, 0.2, 0.3)])
    assert np.allclose(columns[1::2, 2], [0.0, 0.02, 0.04, 0.06])


@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_hidden_is_what_has_another_before_it(seed: int, count: int) -> None:
    """The slow twin looks at every pair of points."""
    points = BOX.centre + np.random.default_rng(seed).uniform(-0.4, 0.4, (count, 3))
    local = transform(inverse(RING[0]), points)
    away, image = np.linalg.norm(local, axis=1), local[:, :2] / local[:, 2:]
    pixels = CAMERA.intrinsics.project(local)
    size = CAMERA.intrinsics.width, CAMERA.intrinsics.height
    inside = [all(-0.5 < p < n - 0.5 for p, n in zip(pixel, size, strict=True)) for pixel in pixels]
    width = 0.04 / np.median(away[inside]) if any(inside) else 1.0
    cells = [tuple(np.floor(each / width)) for each in image]
    wanted = [
        inside[k] and not any(inside[j] and cells[j] == cells[k] and away[j] < away[k] - 0.05 for j in range(count))
        for k in range(count)
    ]
    # Points on the edge of a cell may round either way; random ones never lie there.
    assert unhidden(points, RING[0], CAMERA.intrinsics).tolist() == wanted


def test_nothing_is_seen_from_behind() -> None:
    away = orbit_pose(BOX.centre + np.array([5.0, 0.0, 0.0]), 0.0, np.deg2rad(35), 1.2)
    assert not unhidden(BOX.centre[None], away @ np.diag([-1.0, 1.0, -1.0, 1.0]), CAMERA.intrinsics).any()

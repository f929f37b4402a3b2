"""Where voxels lie: indices by hand, bounds, and refusals."""

import numpy as np
import pytest

from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.voxels import Lattice, coarser, pixels_per_voxel

SMALL = Lattice(np.array([1.0, 2.0, 3.0]), 0.5, (2, 3, 4))


def test_the_flat_index_counts_z_first_and_outside_is_the_count() -> None:
    points = np.array([[1.0, 2.0, 3.0], [1.49, 2.49, 3.51], [1.5, 2.0, 3.0], [1.9, 3.4, 4.9], [0.99, 2.0, 3.0], [2.0, 2.0, 3.0]])
    np.testing.assert_array_equal(SMALL.voxels_of(points), [0, 1, 12, 23, 24, 24])
    assert SMALL.count == 24
    np.testing.assert_allclose(SMALL.high, [2.0, 3.5, 5.0])


def test_the_middle_of_a_voxel_lies_in_it() -> None:
    np.testing.assert_array_equal(SMALL.voxels_of(SMALL.centres), np.arange(24))
    np.testing.assert_allclose(SMALL.centres[1], [1.25, 2.25, 3.75])


def test_a_lattice_around_points_holds_them_with_room_on_every_side() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        points = rng.normal(size=(30, 3)) * rng.uniform(0.01, 3, 3)
        lattice = Lattice.around(points, voxels=20, margin=2)
        np.testing.assert_allclose(lattice.size, np.ptp(points, axis=0).max() / 20)
        room = np.minimum(points.min(axis=0) - lattice.low, lattice.high - points.max(axis=0))
        assert np.all(room >= 2 * lattice.size - 1e-9)
        assert np.all(room < 2.5 * lattice.size + 1e-9)


def test_a_flat_set_of_points_gets_a_lattice_too() -> None:
    assert Lattice.around(np.array([[0, 0, 0], [1.0, 1.0, 0]]), voxels=10, margin=0).shape == (10, 10, 1)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Lattice(np.zeros(2), 1.0, (1, 1, 1)),
        lambda: Lattice(np.array([0.0, np.nan, 0.0]), 1.0, (1, 1, 1)),
        lambda: Lattice(np.zeros(3), 0.0, (1, 1, 1)),
        lambda: Lattice(np.zeros(3), np.inf, (1, 1, 1)),
        lambda: Lattice(np.zeros(3), 1.0, (1, 0, 1)),
        lambda: Lattice(np.zeros(3), 1e-4, (10_000, 10_000, 10_000)),
        lambda: Lattice.around(np.zeros((0, 3))),
        lambda: Lattice.around(np.ones((5, 3))),
    ],
    ids=["corner", "nan", "no size", "endless", "no voxels", "too many", "no points", "one point"],
)
def test_what_is_no_lattice_is_refused(make: object) -> None:
    with pytest.raises(ConfigError, match=r"lattice: got "):
        make()  # type: ignore[operator]


def test_a_coarser_camera_sees_the_same_directions() -> None:
    camera = Intrinsics(width=640, height=480, fx=476.0, fy=470.0, cx=319.5, cy=239.5)
    few = coarser(camera, 10)
    assert (few.width, few.height) == (64, 48)
    blocks = camera.rays().reshape(48, 10, 64, 10, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(few.rays(), blocks, atol=1e-12)
    assert coarser(camera, 1) == camera
    for step in (481, 0):
        with pytest.raises(ConfigError):
            coarser(camera, step)


def test_how_many_pixels_a_voxel_fills() -> None:
    """PC-NBV's camera at distance 1, 40 voxels along a side: 476 / 40 = 11.9."""
    camera = Intrinsics(width=640, height=480, fx=476.0, fy=476.0, cx=319.5, cy=239.5)
    cube = Lattice(np.full(3, -0.5), 1 / 40, (40, 40, 40))
    for centre, pixels in (([1.0, 0, 0], 12), ([0, 0, -2.0], 6), ([0, 100.0, 0], 1), ([0, 0, 0], 476)):
        assert pixels_per_voxel(cube, camera, np.array(centre)) == pixels
    assert pixels_per_voxel(cube, coarser(camera, 100), np.zeros(3)) == 4

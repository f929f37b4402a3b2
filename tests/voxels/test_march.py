"""Rays through voxels: against trying every cube, by hand, and one backend against the other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import voxels as oracle
from viewgain.voxels import Backend, Lattice, march

BACKENDS: tuple[Backend, ...] = ("numpy", "numba")
FLAT = Lattice(np.zeros(3), 1.0, (4, 3, 1))


def rows(lattice: Lattice, paths: np.ndarray) -> list[list[int]]:
    return [[int(voxel) for voxel in column if voxel != lattice.count] for column in paths.T]


@st.composite
def cases(draw: st.DrawFn) -> tuple[Lattice, np.ndarray, np.ndarray, float, np.ndarray]:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shape = tuple(int(count) for count in rng.integers(1, 7, 3))
    lattice = Lattice(rng.normal(size=3), float(rng.uniform(0.1, 2)), shape)
    middle, wide = (lattice.low + lattice.high) / 2, float(np.linalg.norm(lattice.high - lattice.low))
    origin = middle + rng.normal(size=3) * wide * draw(st.sampled_from([0.2, 1.0, 5.0]))
    targets = rng.uniform(lattice.low - 0.2 * wide, lattice.high + 0.2 * wide, (20, 3))
    directions = (targets - origin) * rng.uniform(0.1, 3, (20, 1))
    directions[:6] *= rng.integers(0, 2, (6, 3))  # some along axes and planes
    directions = directions[np.any(directions != 0, axis=1)]
    reach = draw(st.sampled_from([np.inf, 1.0]))
    return lattice, origin, directions, reach, rng.random(lattice.count) < 0.1


@given(cases(), st.sampled_from(BACKENDS))
def test_it_passes_the_cubes_that_the_ray_passes_in_order(case: tuple, backend: Backend) -> None:
    lattice, origin, directions, reach, _ = case
    found = rows(lattice, march(lattice, origin, directions, reach=reach, backend=backend))
    for path, direction in zip(found, directions, strict=True):
        assert path == oracle.passed_voxels(lattice, origin, direction, reach)


@given(cases())
def test_both_backends_agree_to_the_last_voxel(case: tuple) -> None:
    lattice, origin, directions, reach, stop = case
    one, other = (march(lattice, origin, directions, reach=reach, stop=stop, backend=backend) for backend in BACKENDS)
    np.testing.assert_array_equal(one, other)
    assert one.dtype == other.dtype == np.int32


@given(cases(), st.sampled_from(BACKENDS))
def test_a_path_with_stops_is_the_free_path_cut_behind_the_first(case: tuple, backend: Backend) -> None:
    lattice, origin, directions, reach, stop = case
    free = rows(lattice, march(lattice, origin, directions, reach=reach, backend=backend))
    cut = rows(lattice, march(lattice, origin, directions, reach=reach, stop=stop, backend=backend))
    for whole, path in zip(free, cut, strict=True):
        places = [place for place, voxel in enumerate(whole) if stop[voxel]]
        assert path == (whole[: places[0] + 1] if places else whole)


@given(cases(), st.sampled_from(BACKENDS))
def test_neighbours_on_a_path_share_a_face(case: tuple, backend: Backend) -> None:
    lattice, origin, directions, _, _ = case
    for path in rows(lattice, march(lattice, origin, directions, backend=backend)):
        cells = np.array(np.unravel_index(np.array(path, dtype=int), lattice.shape)).T
        assert np.all(np.abs(np.diff(cells, axis=0)).sum(axis=1) == 1)


@pytest.mark.parametrize("backend", BACKENDS)
def test_by_hand_in_a_flat_lattice(backend: Backend) -> None:
    """Voxel (i, j) of 4 x 3 has index 3 i + j."""
    start = np.array([-1.0, 0.5, 0.5])
    along = np.array([[1.0, 0.0, 0.0], [2.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 5.0, 0.0]])
    found = rows(FLAT, march(FLAT, start, along, backend=backend))
    assert found == [[0, 3, 6, 9], [1, 4, 7, 8, 11], [], []]


@pytest.mark.parametrize("backend", BACKENDS)
def test_through_corners_the_order_is_x_before_y(backend: Backend) -> None:
    (found,) = rows(FLAT, march(FLAT, np.array([0.0, 0.0, 0.5]), np.array([[1.0, 1.0, 0.0]]), backend=backend))
    assert found == [0, 3, 4, 7, 8, 11]


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_rays_and_rays_that_miss_have_no_rows(backend: Backend) -> None:
    assert march(FLAT, np.zeros(3), np.zeros((0, 3)), backend=backend).shape == (0, 0)
    assert march(FLAT, np.array([9.0, 9.0, 9.0]), np.array([[1.0, 0, 0]]), backend=backend).shape == (0, 1)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_ray_from_within_starts_in_its_voxel(backend: Backend) -> None:
    start = np.array([2.5, 1.5, 0.5])
    found = rows(FLAT, march(FLAT, start, np.array([[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]]), backend=backend))
    assert found == [[7, 10], [7, 6], [7]]

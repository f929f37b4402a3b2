"""Hull and heap volume where the answer is known."""

import numpy as np
import pytest

from viewgain.parcels import heap_volume, hull_volume


def surface(height: float, side: float = 0.4, count: int = 161) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(0, side, count), np.linspace(0, side, count))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])


def test_a_table_top_heaps_to_its_floor() -> None:
    assert heap_volume(surface(0.3), 0.005) == pytest.approx(0.4 * 0.4 * 0.3, rel=0.03)


def test_only_the_topmost_surface_counts() -> None:
    both = np.concatenate([surface(0.3), surface(0.1)])
    assert heap_volume(both, 0.005) == heap_volume(surface(0.3), 0.005)


def test_a_gap_of_two_cells_is_filled() -> None:
    points = surface(0.2)
    gap = points[np.abs(points[:, 0] - 0.2) > 0.004]
    assert heap_volume(gap, 0.005) == pytest.approx(heap_volume(points, 0.005), rel=0.01)


def test_hull_of_a_tetrahedron_and_of_too_little() -> None:
    assert hull_volume(np.vstack([np.zeros(3), np.eye(3)])) == pytest.approx(1 / 6)
    assert hull_volume(np.zeros((3, 3))) == 0
    assert heap_volume(np.zeros((0, 3)), 0.01) == 0

"""Where a row of points begins and ends: at the last point, or where their density halves."""

import numpy as np

from viewgain.arrays import Vector

_CELL = 0.005
"""Width of the cells that density is counted in, metres; about a pixel at 1 m."""
_BLUR = np.exp(-0.5 * (np.arange(-5, 6) / 2) ** 2) / np.sum(np.exp(-0.5 * (np.arange(-5, 6) / 2) ** 2))
"""Two cells wide: pixels, up to 1 cm apart, make no gaps."""
_PLATEAU = (0.25, 0.75)
"""The plateau is the median density between these quantiles of the weight."""
_LARGEST_HOLE = 4
"""So many empty cells (2 cm) may lie inside a row; farther points are another object's."""


def raw_ends(along: Vector) -> tuple[float, float]:
    """Return the least and the greatest of (n,) positions, n >= 1."""
    return float(along.min()), float(along.max())


def half_density_ends(along: Vector, weight: Vector) -> tuple[float, float]:
    """Return where the density of weighted positions falls to half its plateau, going out from their median.

    Noise along the row blurs its ends evenly, so the half-way point stays; single flying points make no density.

    Args:
        along: (n,) positions, metres, n >= 1.
        weight: (n,) positive weights: the area that each point stands for, so that the plateau is level.
    """
    margin = len(_BLUR)
    low = along.min() - margin * _CELL
    cell = ((along - low) / _CELL).astype(int)
    density = np.convolve(np.bincount(cell, weight, cell.max() + margin), _BLUR, mode="same")
    share = np.cumsum(density) / density.sum()
    first, middle, last = np.searchsorted(share, (_PLATEAU[0], 0.5, _PLATEAU[1]))
    half = float(np.median(density[first : last + 1])) / 2
    dense = np.flatnonzero(density >= half)
    run = np.split(dense, np.flatnonzero(np.diff(dense) > _LARGEST_HOLE) + 1)
    own = min(run, key=lambda part: max(part[0] - middle, middle - part[-1], 0))
    begin, end = _crossing(density, int(own[0]), -1, half), _crossing(density, int(own[-1]), 1, half)
    return float(low + (begin + 0.5) * _CELL), float(low + (end + 0.5) * _CELL)


def _crossing(density: Vector, inside: int, step: int, level: float) -> float:
    """Return where, between a dense cell and the next one outwards, the density passes ``level``."""
    outside = inside + step
    beyond = density[outside] if 0 <= outside < len(density) else 0.0
    return inside + step * float((density[inside] - level) / max(density[inside] - beyond, 1e-12))

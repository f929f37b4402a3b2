"""Leave out what has no surface: triangles without area, then vertices that no triangle uses."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Mask, Points

Integers: TypeAlias = NDArray[np.integer[Any]]
"""The indices of trimesh; they become int32 in the mesh."""

_FLAT = 1e-12
_CHUNK = 2**18
"""Triangles at a time, so that ten million need no more memory than these."""


def cleaned(vertices: Points, faces: Integers) -> tuple[Points, Integers]:
    """Return the mesh without degenerate triangles and unused vertices; the order of the rest is kept.

    Every index must name a vertex. Where all triangles are degenerate, none is left.
    """
    flat = degenerate(vertices, faces)
    kept = faces[~flat] if flat.any() else faces
    used = np.zeros(len(vertices), dtype=bool)
    used[kept] = True
    if used.all():
        return vertices, kept
    renumbered = np.cumsum(used) - 1
    return vertices[used], renumbered[kept]


def degenerate(vertices: Points, faces: Integers) -> Mask:
    """Return which triangles (f,) are points or lines as far as float64 can tell.

    That is: lower than 1e-12 of the largest coordinate above their longest side. Those with NaN or infinite corners are not.
    """
    finite = vertices[np.isfinite(vertices).all(axis=1)]
    largest = float(np.abs(finite).max(initial=0.0)) or 1.0
    flat = np.zeros(len(faces), dtype=bool)
    for start in range(0, len(faces), _CHUNK):
        corners = vertices[faces[start : start + _CHUNK]] / largest
        sides = np.roll(corners, -1, axis=1) - corners
        doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        flat[start : start + _CHUNK] = doubled <= _FLAT * np.linalg.norm(sides, axis=2).max(axis=1)
    return flat

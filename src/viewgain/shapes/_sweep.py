"""Sweeps: a cross-section carried along a path by frames that do not spin about it.

The frames come from the double reflection method (Wang et al. 2008, "Computation of rotation minimizing frames").
"""

from collections.abc import Sequence

import numpy as np

from viewgain.arrays import Array, Points, Points2
from viewgain.errors import ConfigError
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part, skin
from viewgain.shapes._path import Line

_Three = tuple[float, float, float]
_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]


def sweep(path: Line, section: Points2, *, scale: Array | Sequence[float] | None = None, up: _Three = (0.0, 0.0, 1.0)) -> Part:
    """Return the solid that a section sweeps along an open path; both ends are flat.

    At a bend the section stands across the bisector, so tight bends come out thinner.

    Args:
        path: (m, 3) points, none equal to the next.
        section: (n, 2) counter-clockwise outline; its first axis points to the left of the path, its second upwards.
        scale: (m,) factor of the section at each point, or (m, 2) factors of its two axes; positive.
        up: What the section's second axis leans to at the start of the path.

    Raises:
        ConfigError: If two neighbouring points of the path coincide.
    """
    points = np.asarray(path, dtype=float)
    tangents = _tangents(points)
    lefts = _transported(points, tangents, up)
    return skin(_rings(points, tangents, lefts, section, scale), points[0], points[-1])


def rod(start: Sequence[float], end: Sequence[float], radius: float, end_radius: float | None = None, sides: int = 8) -> Part:
    """Return the straight round bar from one point to another, tapered if ``end_radius`` is given."""
    (ax, ay, az), (bx, by, bz) = start, end
    tangent = _unit((bx - ax, by - ay, bz - az))
    left = _left_of(tangent, (0.0, 0.0, 1.0))
    radii = (radius, radius if end_radius is None else end_radius)
    frame = np.array([left, _cross(tangent, left)])
    rim = unit_circle(sides) @ frame
    ends = np.array([start, end], dtype=float)
    return skin(ends[:, None] + np.array(radii)[:, None, None] * rim, ends[0], ends[1])


def _rings(points: Points, tangents: Points, lefts: Points, section: Points2, scale: Array | Sequence[float] | None) -> Array:
    """Return the (m, n, 3) sections in their frames."""
    frames = np.stack([lefts, _crosses(tangents, lefts)], axis=1)  # [m, 2, 3]
    if scale is not None:
        factor = np.asarray(scale, dtype=float)
        frames = frames * (factor[:, None, None] if factor.ndim == 1 else factor[:, :, None])
    return np.asarray(points[:, None] + section @ frames)


def _tangents(points: Points) -> Points:
    """Return the unit direction of the path at each point: along the bisector of its two segments."""
    segments = points[1:] - points[:-1]
    length = np.sqrt((segments * segments).sum(axis=1))
    if not length.min() > 0:
        raise ConfigError("two neighbouring points of a path coincide, so it has no direction there; drop one of them")
    units = segments / length[:, None]
    both = np.concatenate([units[:1], units])
    both[1:-1] += units[1:]
    return np.asarray(both / np.sqrt((both * both).sum(axis=1))[:, None])


def _transported(points: Points, tangents: Points, up: _Three) -> Points:
    """Return the (m, 3) unit vectors to the left of the path, none spinning about it.

    Plain floats: on paths of a dozen points they are faster than arrays.
    """
    places: list[list[float]] = points.tolist()
    ways: list[list[float]] = tangents.tolist()
    lefts = [_left_of(_triple(ways[0]), up)]
    for p, q, before, after in zip(places, places[1:], ways, ways[1:], strict=False):
        chord = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
        carried = _reflected(_triple(before), chord)
        rest = (after[0] - carried[0], after[1] - carried[1], after[2] - carried[2])
        lefts.append(_reflected(_reflected(lefts[-1], chord), rest))
    return np.array(lefts)


def _left_of(tangent: _Three, up: _Three) -> _Three:
    """Return the unit vector across a direction and ``up``; a direction that runs along ``up`` is given another one."""
    across = _cross(up, tangent)
    if across[0] ** 2 + across[1] ** 2 + across[2] ** 2 < 1e-6:
        across = _cross((-up[2], up[0], up[1]), tangent)
    return _unit(across)


def _crosses(a: Points, b: Points) -> Points:
    """Return the cross products row by row; on few rows faster than numpy's own."""
    return np.asarray(a[:, _NEXT] * b[:, _AFTER] - a[:, _AFTER] * b[:, _NEXT])


def _triple(v: Sequence[float]) -> _Three:
    """Return the three numbers as a tuple."""
    return v[0], v[1], v[2]


def _cross(a: _Three, b: _Three) -> _Three:
    """Return the cross product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _unit(v: _Three) -> _Three:
    """Return the vector at length 1; refuse one of no length."""
    length = (v[0] ** 2 + v[1] ** 2 + v[2] ** 2) ** 0.5
    if length == 0:
        raise ConfigError("a bar starts where it ends, so it has no direction; move one of its ends")
    return v[0] / length, v[1] / length, v[2] / length


def _reflected(v: _Three, normal: _Three) -> _Three:
    """Return ``v`` mirrored in the plane across ``normal``; a normal of no length changes nothing."""
    square = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
    if square < 1e-30:
        return v
    share = 2 * (v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]) / square
    return v[0] - share * normal[0], v[1] - share * normal[1], v[2] - share * normal[2]

"""From parts to an object: whole groups moved, repeated and mirrored, and all of it joined into one mesh."""

from collections.abc import Iterable, Sequence

import numpy as np

from viewgain.meshes import TriangleMesh
from viewgain.shapes._part import Axis, Part

Parts = list[Part]


def shifted(parts: Iterable[Part], x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Parts:
    """Return all parts, shifted."""
    return [part.at(x, y, z) for part in parts]


def turned(parts: Iterable[Part], angle: float, axis: Axis = "z") -> Parts:
    """Return all parts, turned about an axis through the origin, radians."""
    return [part.turned(angle, axis) for part in parts]


def both_sides(parts: Iterable[Part]) -> Parts:
    """Return all parts, each followed by its mirror image across y = 0."""
    return [side for part in parts for side in (part, part.mirrored())]


def around(part: Part, count: int, start: float = 0.0) -> Parts:
    """Return ``count`` copies at equal steps about the z axis, the first turned by ``start`` radians."""
    return [part.turned(start + k * 2 * np.pi / count) for k in range(count)]


def spread(count: int, width: float) -> list[float]:
    """Return ``count`` places at equal steps from -width/2 to width/2; the middle for a single one."""
    return [0.0] if count == 1 else [width * (k / (count - 1) - 0.5) for k in range(count)]


def assemble(parts: Sequence[Part], name: str) -> TriangleMesh:
    """Return one mesh of all parts, standing on z = 0 with the middle of its footprint at the origin."""
    vertices = np.concatenate([part.vertices for part in parts])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices -= ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2])
    faces, offset = [], 0
    for part in parts:
        faces.append(part.faces + np.int32(offset))
        offset += len(part.vertices)
    return TriangleMesh(vertices, np.concatenate(faces), name)

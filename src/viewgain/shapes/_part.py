"""A part: one closed surface of triangles, wound so that the right-hand rule points out of it. Objects are lists of parts.

Every curved part is a skin over a stack of rings, and the triangles of a skin depend on the counts alone, so they are made once.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import cos, sin
from typing import Literal

import numpy as np

from viewgain.arrays import Array, Faces, Points, Vector3

Axis = Literal["x", "y", "z"]
_TURNED: dict[Axis, tuple[int, int]] = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A closed, outward-wound piece of an object; parts of one object may run through each other."""

    vertices: Points
    """(v, 3) corners, metres."""
    faces: Faces
    """(f, 3) indices; shared between parts of the same build, never written to."""

    def at(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> "Part":
        """Return the part shifted."""
        shift = (x, y, z)
        return Part(self.vertices + shift, self.faces)

    def turned(self, angle: float, axis: Axis = "z") -> "Part":
        """Return the part turned about an axis through the origin, right-handed, radians."""
        i, j = _TURNED[axis]
        c, s = cos(angle), sin(angle)
        vertices = self.vertices.copy()
        vertices[:, i] = c * self.vertices[:, i] - s * self.vertices[:, j]
        vertices[:, j] = s * self.vertices[:, i] + c * self.vertices[:, j]
        return Part(vertices, self.faces)

    def stretched(self, x: float = 1.0, y: float = 1.0, z: float = 1.0) -> "Part":
        """Return the part scaled along each axis by positive factors."""
        return Part(self.vertices * (x, y, z), self.faces)

    def mirrored(self) -> "Part":
        """Return the mirror image across the plane y = 0, wound outwards again."""
        return Part(self.vertices * (1.0, -1.0, 1.0), self.faces[:, ::-1])


def skin(rings: Array, start: Vector3 | None = None, end: Vector3 | None = None) -> Part:
    """Return the surface over a stack of rings, closed at either end by a fan.

    Args:
        rings: (k, n, 3) closed polygons, counter-clockwise for who looks back from the last ring to the first.
        start: (3,) tip of the fan that closes the first ring; its mean if not given. The ring must be star-shaped around it.
        end: The same for the last ring.
    """
    k, n = rings.shape[:2]
    vertices = np.empty((k * n + 2, 3))
    vertices[:-2] = rings.reshape(-1, 3)
    vertices[-2] = rings[0].sum(axis=0) / n if start is None else start
    vertices[-1] = rings[-1].sum(axis=0) / n if end is None else end
    return Part(vertices, _skin_faces(k, n))


def loop_skin(rings: Array) -> Part:
    """Return the ring-shaped surface whose last of (k, n, 3) rings joins the first."""
    k, n = rings.shape[:2]
    return Part(rings.reshape(-1, 3), _wall_faces(k, n, closed=True))


@lru_cache(maxsize=512)
def _wall_faces(k: int, n: int, *, closed: bool) -> Faces:
    """Return two triangles for each side of each pair of neighbouring rings."""
    ring, side = np.divmod(np.arange((k if closed else k - 1) * n), n)
    beside, above = (side + 1) % n, (ring + 1) % k
    a, b, c, d = ring * n + side, ring * n + beside, above * n + beside, above * n + side
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int32)
    faces.flags.writeable = False
    return faces


@lru_cache(maxsize=512)
def _skin_faces(k: int, n: int) -> Faces:
    """Return the walls and the two fans; the tips are the last two vertices."""
    side = np.arange(n)
    beside, last, tip = (side + 1) % n, (k - 1) * n, np.full(n, k * n)
    start = np.stack([tip, beside, side], axis=1)
    end = np.stack([tip + 1, last + side, last + beside], axis=1)
    faces = np.concatenate([_wall_faces(k, n, closed=False), start, end]).astype(np.int32)
    faces.flags.writeable = False
    return faces

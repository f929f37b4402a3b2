"""Simple solids. Those with a flat bottom stand on z = 0 about the z axis; the round ones are centred on the origin."""

from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Faces
from viewgain.shapes._lathe import lathe, lathe_ring
from viewgain.shapes._outline import rectangle, unit_circle
from viewgain.shapes._part import Part, skin
from viewgain.shapes._path import arc

_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (-0.5, 0.5) for x in (-0.5, 0.5)], dtype=float)
_BLOCK: Faces = np.array(
    [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ],
    dtype=np.int32,
)


def block(x: float, y: float, z: float) -> Part:
    """Return a sharp-edged cuboid of 12 triangles."""
    return Part(_CORNERS * (x, y, z), _BLOCK)


def tapered(bottom: tuple[float, float], top: tuple[float, float], z: float, shift: tuple[float, float] = (0.0, 0.0)) -> Part:
    """Return a cuboid whose top face has other side lengths than its bottom and is shifted against it."""
    low, high = _CORNERS[:4] * (*bottom, 0.0), _CORNERS[4:] * (*top, z) + (*shift, 0.0)
    return Part(np.concatenate([low, high]), _BLOCK)


def wedge(x: float, y: float, z: float, ridge: float = 0.0) -> Part:
    """Return a roof: a rectangle below, and above it a ridge along y at x = ``ridge``, as long as the rectangle."""
    bottom = np.array([[x / 2, -y / 2, 0], [-x / 2, -y / 2, 0], [ridge, -y / 2, z]])
    return skin(np.stack([bottom, bottom * (1, -1, 1)]))


def board(x: float, y: float, z: float, bevel: float | None = None) -> Part:
    """Return a cuboid of 64 triangles with all edges and corners bevelled: by an eighth of its smallest side, at most a fifth."""
    least = min(x, y, z)
    cut = least / 8 if bevel is None else min(bevel, least / 5)
    whole, inset = _board_template()
    return Part(whole * (x, y, z) + inset * cut, _board_faces())


def cylinder(radius: float, z: float, sides: int = 16) -> Part:
    """Return an upright cylinder (a regular prism of ``sides`` faces inscribed in it)."""
    return lathe([(radius, 0.0), (radius, z)], sides)


def frustum(bottom: float, top: float, z: float, sides: int = 16) -> Part:
    """Return an upright cone cut off at radius ``top``; 0 gives a whole cone."""
    return lathe([(bottom, 0.0), (top, z)], sides)


def ellipsoid(x: float, y: float, z: float, rings: int = 8, sides: int = 16) -> Part:
    """Return an ellipsoid of the given full widths."""
    return Part(_unit_ball(rings, sides).vertices * (x / 2, y / 2, z / 2), _unit_ball(rings, sides).faces)


def cushion(x: float, y: float, z: float, softness: float = 0.4) -> Part:
    """Return a rounded cuboid of the given full widths, standing on z = 0: a superellipsoid, 1 for an ellipsoid."""
    ball = _unit_ball(8, 24)
    vertices = np.sign(ball.vertices) * np.abs(ball.vertices) ** softness
    return Part(vertices * (x / 2, y / 2, z / 2) + (0.0, 0.0, z / 2), ball.faces)


def torus(radius: float, thickness: float, sides: int = 24, around: int = 10) -> Part:
    """Return a ring about the z axis: the centre line at ``radius``, the tube ``thickness`` across."""
    return lathe_ring(unit_circle(around) * (thickness / 2) + (radius, 0.0), sides)


@lru_cache(maxsize=32)
def _unit_ball(rings: int, sides: int) -> Part:
    """Return the ball of radius 1 with ``rings`` circles between its poles; tiny rounding errors are cleared."""
    profile = arc(1.0, -np.pi / 2, np.pi / 2, rings + 2)
    profile[[0, -1], 0] = 0.0
    ball = lathe(profile, sides)
    return Part(np.where(np.abs(ball.vertices) < 1e-12, 0.0, ball.vertices), ball.faces)


@lru_cache(maxsize=1)
def _board_template() -> tuple[Array, Array]:
    """Return the (v, 3) share of the side lengths and of the bevel in each vertex of a board."""
    outline = np.repeat(rectangle(1.0, 1.0), 2, axis=0)
    cut = np.sign(outline) * [[0, -1], [-1, 0], [-1, 0], [0, -1], [0, -1], [-1, 0], [-1, 0], [0, -1]]
    whole, inset = np.zeros((4, 8, 3)), np.zeros((4, 8, 3))
    whole[:, :, :2], inset[:, :, :2] = outline, cut
    whole[2:, :, 2] = 1.0
    inset[[0, 3], :, :2] -= np.sign(outline)
    inset[[1, 2], :, 2] = [[1.0], [-1.0]]
    tips = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return np.concatenate([whole.reshape(-1, 3), tips]), np.concatenate([inset.reshape(-1, 3), np.zeros((2, 3))])


@lru_cache(maxsize=1)
def _board_faces() -> Faces:
    """Return the triangles of every board."""
    return skin(np.zeros((4, 8, 3))).faces

"""Objects of no category: random solids put against one another.

Who learns from them learns what surfaces do behind what is seen, and not what chairs look like. To train on random assemblies of
solids and be tested on objects: Tobin et al. 2018, "Domain randomization and generative models for robotic grasping". The grammar
is ours.
"""

from math import exp, log, pi

import numpy as np

from viewgain.arrays import Vector3
from viewgain.shapes._assemble import Parts, both_sides, shifted, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import lathe
from viewgain.shapes._part import Part
from viewgain.shapes._primitives import board, cushion, cylinder, ellipsoid, frustum, tapered, wedge

_THIN = 0.03
"""Least thickness of anything, core's sides being about 1: thinner walls fall between the points of a cloud."""


def composite(dice: Dice) -> Parts:
    """Return a core and 2 to 7 groups of solids, each joined to one that is there already; all stretched at random.

    Cores: one solid (40 %), a carcass with open sides and shelves (25 %), a turned body (15 %), plates on posts (20 %). Groups: a
    single solid, a pair, or a row of 2 to 5. 75 % of the objects are symmetric across y = 0. Sides of the core 0.15 to 1, factors
    of the stretching 0.5 to 1.7, uniform in their logarithms.
    """
    kind = dice.pick(solid=0.4, carcass=0.25, turned=0.15, plates=0.2)
    core = {"solid": _single, "carcass": _carcass, "turned": _turned, "plates": _plates}[kind]
    parts, symmetric = core(dice, _widths(dice, 0.15, 1.0)), dice.chance(0.75)
    for _ in range(dice.count(2, 7)):
        host = parts[dice.count(0, len(parts) - 1)]
        parts = [*parts, *_joined(dice, host, symmetric=symmetric)]
    x, y, z = _widths(dice, 0.5, 1.7)
    return [part.stretched(x, y, z) for part in parts]


def _single(dice: Dice, size: Vector3) -> Parts:
    """Return one solid."""
    return [_solid(dice, size)]


def _carcass(dice: Dice, size: Vector3) -> Parts:
    """Return a box of boards: a bottom, each other side with 75 %, and in half of them 1 to 3 shelves."""
    (x, y, z), t = size, dice.between(_THIN, 0.07)
    upright, standing = board(t, y, z), board(x, t, z)
    sides = [
        upright.at((t - x) / 2), upright.at((x - t) / 2), standing.at(y=(t - y) / 2), standing.at(y=(y - t) / 2),
        board(x, y, t).at(z=z - t),
    ]  # fmt: skip
    shelves = [board(0.98 * x, 0.98 * y, t).at(z=level + z / 2) for level in spread(dice.count(1, 3), 0.6 * z)]
    return [board(x, y, t), *(side for side in sides if dice.chance(0.75)), *(shelves if dice.chance(0.5) else [])]


def _turned(dice: Dice, size: Vector3) -> Parts:
    """Return a body of revolution with 4 to 7 random radii, upright or lying along x."""
    count = dice.count(4, 7)
    body = lathe([(dice.between(0.12, 0.5), level / (count - 1)) for level in range(count)], dice.count(4, 12) * 2)
    laid = body.turned(pi / 2, "y") if dice.chance(0.5) else body
    return [_fitted(laid, size)]


def _plates(dice: Dice, size: Vector3) -> Parts:
    """Return 1 to 3 plates between four posts, which may stand in from the corners."""
    (x, y, z), t = size, dice.between(_THIN, 0.1)
    inset = dice.between(0.6, 0.95)
    post = _fitted(cylinder(0.5, 1.0, dice.count(4, 10)), np.array([t, t, z]))
    posts = both_sides([post.at(side * inset * (x - t) / 2, inset * (y - t) / 2, z / 2) for side in (1, -1)])
    levels = [1.0, dice.between(0.1, 0.5), dice.between(0.55, 0.9)][: dice.count(1, 3)]
    return [*posts, *(board(x, y, t).at(z=level * z - t) for level in levels)]


def _joined(dice: Dice, host: Part, *, symmetric: bool) -> Parts:
    """Return a group of solids that stand out of one side of a part's bounding box and run into it: one (70 %), or a row.

    Each side of a solid is 0.2 to 1.4 of the host's, slabs (30 %) and rods (25 %) are thin along one and two axes. Where objects
    are symmetric the group is mirrored, or stands in the middle.
    """
    low, high = host.vertices.min(axis=0), host.vertices.max(axis=0)
    axis = {"x": 0, "y": 1, "z": 2}[dice.pick(x=0.3, y=0.25, z=0.45)]
    size = _size(dice, high - low)
    place = (low + high) / 2 + (high - low) * [dice.between(-0.4, 0.4) for _ in range(3)]
    outwards = dice.between(-0.2, 0.45) * size[axis]
    place[axis] = high[axis] + outwards if dice.chance(0.65) else low[axis] - outwards
    steps = [np.zeros(3)]
    if dice.chance(0.3):
        along = _others(axis)[dice.count(0, 1)]
        place[along] = (low[along] + high[along]) / 2
        steps = [np.eye(3)[along] * step for step in spread(dice.count(2, 5), 0.8 * float(high[along] - low[along]))]
    solid = _solid(dice, size)
    group = [solid.at(*(place + step)) for step in steps]
    if not symmetric:
        return group
    return both_sides(group) if axis == 1 or dice.chance(0.5) else shifted(group, y=-float(place[1]))


def _size(dice: Dice, host: Vector3) -> Vector3:
    """Return the full widths of what is joined to a host of these."""
    size, axis = host * _widths(dice, 0.2, 1.4), dice.count(0, 2)
    thin = {"block": (), "slab": (axis,), "rod": _others(axis)}[dice.pick(block=0.45, slab=0.3, rod=0.25)]
    for each in thin:
        size[each] *= dice.between(0.08, 0.3)
    return np.maximum(size, _THIN)


def _solid(dice: Dice, size: Vector3) -> Part:
    """Return a solid of the given full widths about the origin."""
    x, y, z = size
    kind = dice.pick(board=0.36, cylinder=0.26, ellipsoid=0.1, cushion=0.1, tapered=0.08, wedge=0.05, cone=0.05)
    if kind == "cylinder":
        rod = cylinder(0.5, 1.0, dice.count(3, 10) * 2)
        return _fitted({"x": rod.turned(pi / 2, "y"), "y": rod.turned(pi / 2, "x"), "z": rod}[dice.pick(x=1, y=1, z=1)], size)
    if kind == "board":
        return board(x, y, z).at(z=-z / 2)
    if kind == "tapered":
        return _fitted(tapered((1.0, 1.0), (dice.between(0.4, 0.9), dice.between(0.4, 0.9)), 1.0), size)
    if kind == "wedge":
        return _fitted(wedge(1.0, 1.0, 1.0, dice.between(-0.4, 0.4)), size)
    if kind == "cone":
        return _fitted(frustum(0.5, dice.between(0.1, 0.4), 1.0, dice.count(4, 8) * 2), size)
    return ellipsoid(x, y, z) if kind == "ellipsoid" else cushion(x, y, z, dice.between(0.3, 0.8)).at(z=-z / 2)


def _fitted(part: Part, size: Vector3) -> Part:
    """Return a part stretched to the given full widths and put about the origin."""
    low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
    x, y, z = -(low + high) / 2
    return part.at(x, y, z).stretched(*(size / (high - low)))


def _widths(dice: Dice, low: float, high: float) -> Vector3:
    """Return three widths, uniform in their logarithms."""
    return np.array([exp(dice.between(log(low), log(high))) for _ in range(3)])


def _others(axis: int) -> tuple[int, ...]:
    """Return the two other axes."""
    return tuple(each for each in range(3) if each != axis)

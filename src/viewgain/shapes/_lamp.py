"""Lamps: on the floor or on a table."""

from collections.abc import Callable
from itertools import pairwise
from math import cos, pi, sin

from viewgain.shapes._assemble import Parts, around
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import hollow, lathe
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import smooth
from viewgain.shapes._primitives import board, cylinder, ellipsoid
from viewgain.shapes._sweep import rod, sweep


def lamp(dice: Dice) -> Parts:
    """Return a lamp: on the floor (50 %, 1.2 to 1.8 m high) or on a table (0.3 to 0.7 m); uniform.

    Stand: straight pole, turned body (tables only), arching pole, 2 or 3 jointed arms, tripod (or 4 legs), or a pole with 2 to 4
    branches. Foot: disc (50 %), dome, block. Shade: cone (30 %), drum (25 %), bell (20 %), globe (15 %), 4 to 8 sides (10 %).
    """
    tall = dice.chance(0.5)
    height = dice.between(1.2, 1.8) if tall else dice.between(0.3, 0.7)
    size = dice.between(0.14, 0.26) if tall else dice.between(0.25, 0.4) * height
    options: dict[str, Callable[[Dice, float, float], Parts]] = {
        "pole": _pole, "turned": _turned, "arch": _arch, "jointed": _jointed, "tripod": _tripod, "branches": _branches,
    }  # fmt: skip
    style = dice.pick(
        pole=0.25, turned=0.0 if tall else 0.35, arch=0.15, jointed=0.2, tripod=0.2 if tall else 0.08, branches=0.12
    )
    return options[style](dice, height, size)


def _foot(dice: Dice, radius: float) -> Part:
    """Return the plate a lamp stands on."""
    style = dice.pick(disc=0.5, dome=0.3, block=0.2)
    if style == "block":
        return board(1.8 * radius, 1.8 * radius, 0.03)
    if style == "dome":
        return lathe([(radius, 0.0), (radius, 0.008), (0.75 * radius, 0.025), (0.35 * radius, 0.04), (0.1 * radius, 0.045)])
    return lathe([(radius, 0.0), (radius, 0.016), (0.96 * radius, 0.02)], dice.count(10, 16) * 2)


def _shade(dice: Dice, radius: float) -> Part:
    """Return a shade whose rim lies on z = 0, open below, or a globe."""
    style = dice.pick(drum=0.25, cone=0.3, bell=0.2, globe=0.15, polygon=0.1)
    if style == "globe":
        return ellipsoid(1.6 * radius, 1.6 * radius, dice.between(1.3, 1.7) * radius, 10, 20).at(z=0.6 * radius)
    top, tall = (
        {"drum": dice.between(0.8, 1.0), "bell": 0.3}.get(style, dice.between(0.3, 0.65)) * radius,
        dice.between(0.9, 1.5) * radius,
    )
    upturned = [(top, 0.0), (radius, tall)]
    if style == "bell":
        upturned = [(top, 0.0), (1.3 * top, 0.3 * tall), (1.7 * top, 0.6 * tall), (2.4 * top, 0.88 * tall), (radius, tall)]
    shell = lathe(hollow(upturned, 0.04 * radius, 0.03 * tall), dice.count(4, 8) if style == "polygon" else 28)
    return shell.turned(pi, "x").at(z=tall)


def _pole(dice: Dice, height: float, size: float) -> Parts:
    """Return a straight pole under a shade."""
    r = dice.between(0.006, 0.014) + 0.004 * height
    foot = dice.between(0.6, 0.9) * size
    return [_foot(dice, foot), cylinder(r, height - 0.4 * size, 10), _shade(dice, size).at(z=height - 1.1 * size)]


def _turned(dice: Dice, height: float, size: float) -> Parts:
    """Return a turned or vase-like body under a shade."""
    body = 0.62 * height
    knots = [(dice.between(0.3, 0.6) * size, 0.0)]
    knots += [(dice.between(0.15, 0.7) * size, body * (k + 1) / 5) for k in range(3)]
    profile = smooth([*knots, (0.12 * size, 0.85 * body), (0.1 * size, body)], 16)
    profile[:, 0] = profile[:, 0].clip(0.08 * size)
    pole = cylinder(0.05 * size, height - 0.3 * size - body + 0.01, 8).at(z=body - 0.01)
    return [lathe(profile, dice.count(3, 10) * 2), pole, _shade(dice, size).at(z=height - 1.1 * size)]


def _arch(dice: Dice, height: float, size: float) -> Parts:
    """Return a pole that bends over to the front, the shade hanging from its end."""
    reach = dice.between(0.35, 0.6) * height
    path = smooth([(0, 0, 0), (-0.06 * height, 0, 0.55 * height), (0.25 * reach, 0, height), (reach, 0, 0.86 * height)], 16)
    shade = _shade(dice, 0.8 * size)
    low = 0.86 * height - 1.1 * size
    cord = rod((reach, 0.0, low + 0.5 * size), (reach, 0.0, 0.87 * height), 0.006)
    return [_foot(dice, 1.1 * size), sweep(path, unit_circle(8) * (0.008 + 0.004 * height)), shade.at(reach, z=low), cord]


def _jointed(dice: Dice, height: float, size: float) -> Parts:
    """Return 2 or 3 straight arms joined by knuckles, and a reflector that looks down."""
    joints = [(0.0, 0.0)]
    count, way = dice.count(2, 3), 1.0
    for k in range(count):
        angle = dice.between(0.15, 0.55) * way
        x, z = joints[-1]
        long = height / count
        joints.append((x - long * sin(angle), z + long * cos(angle)))
        way = -way if k == 0 else way
    r = 0.006 + 0.005 * height
    arms = [rod((ax, 0.0, az), (bx, 0.0, bz), r) for (ax, az), (bx, bz) in pairwise(joints)]
    knuckles = [ellipsoid(4 * r, 3 * r, 4 * r, 5, 10).at(x, 0.0, z) for x, z in joints[1:]]
    x, z = joints[-1]
    head = _shade(dice, 0.55 * size).at(z=-0.6 * size).turned(-dice.between(0.2, 1.0), "y").at(x, 0.0, z)
    return [_foot(dice, 0.8 * size), *arms, *knuckles, head]


def _tripod(dice: Dice, height: float, size: float) -> Parts:
    """Return 3 or 4 legs that meet under the shade."""
    top, count, reach = height - 1.1 * size, dice.count(3, 4), dice.between(0.18, 0.3) * height
    r = 0.006 + 0.006 * height
    legs = around(rod((reach, 0.0, 0.0), (0.02, 0.0, top), 0.7 * r, r), count)
    ties = around(rod((0.0, 0.0, 0.4 * top), (0.6 * reach, 0.0, 0.4 * top), 0.5 * r), count) if dice.chance(0.5) else []
    return [*legs, *ties, cylinder(2.2 * r, 0.5 * size, 12).at(z=top - 0.02), _shade(dice, size).at(z=top)]


def _branches(dice: Dice, height: float, size: float) -> Parts:
    """Return a pole that ends in 2 to 4 bent arms, each with a small shade."""
    count, reach, r = dice.count(2, 4), dice.between(0.8, 1.3) * size, 0.006 + 0.005 * height
    fork = height - 1.6 * size
    path = smooth([(0, 0, fork), (0.6 * reach, 0, fork - 0.1 * size), (reach, 0, fork + 0.7 * size)], 9)
    shade = _shade(dice, 0.45 * size).at(reach, z=fork + 0.6 * size)
    arms = around(sweep(path, unit_circle(8) * 0.8 * r), count)
    return [_foot(dice, 0.9 * size), cylinder(r, fork + 0.1 * size, 10), *arms, *around(shade, count)]

"""Vases."""

from math import pi

import numpy as np

from viewgain.arrays import Points2
from viewgain.shapes._assemble import Parts
from viewgain.shapes._dice import Dice
from viewgain.shapes._ear import ear
from viewgain.shapes._lathe import hollow, lathe
from viewgain.shapes._part import Part
from viewgain.shapes._path import smooth
from viewgain.shapes._primitives import ellipsoid


def vase(dice: Dice) -> Parts:
    """Return a vase: 0.15 to 0.6 m high without its lid, radius 0.22 to 0.38 of the height; uniform.

    Profile: free, through 4 to 6 uniform radii (45 %), amphora or trumpet (15 % each), bowl, double gourd. Round (50 %), fluted
    with 5 to 16 lobes that may twist (30 %), or of 3 to 8 sides. A foot (30 %), 2 or 3 handles (30 %), a lid (12 %).
    """
    height, radius = dice.between(0.15, 0.6), dice.between(0.22, 0.38)
    radius *= height
    profile = _vase_profile(dice, height, radius)
    finish = dice.pick(round=0.5, sided=0.2, fluted=0.3)
    sides = dice.count(3, 8) if finish == "sided" else dice.count(12, 20) * 2
    wall = lathe(hollow(profile, dice.between(0.04, 0.08) * radius, 0.04 * height), sides)
    if finish == "fluted":
        wall = _fluted(
            wall, dice.count(5, 16), dice.between(0.03, 0.08), dice.between(-3.0, 3.0) / height if dice.chance(0.4) else 0.0
        )
    parts = [wall]
    if dice.chance(0.3):
        parts.append(
            lathe([(0.7 * radius, -0.04 * height), (0.75 * radius, -0.02 * height), (0.9 * profile[0, 0], 0.01 * height)], sides)
        )
    if dice.chance(0.3):
        low, high = 0.45 * height, 0.86 * height
        r_low, r_high = (float(np.interp(z, profile[:, 1], profile[:, 0])) for z in (low, high))
        out = max(r_low, r_high) + dice.between(0.15, 0.4) * radius
        handle = ear([(0.95 * r_low, low), (out, 0.6 * height), (out, 0.78 * height), (0.93 * r_high, high)], 0.09 * radius)
        handles = dice.count(2, 3)
        parts += [handle.turned(2 * pi * k / handles) for k in range(handles)]
    if dice.chance(0.12):
        rim = float(profile[-1, 0])
        parts += [
            lathe([(1.05 * rim, height), (rim, height + 0.1 * rim), (0.3 * rim, height + 0.45 * rim)], sides),
            ellipsoid(0.5 * rim, 0.5 * rim, 0.5 * rim).at(z=height + 0.6 * rim),
        ]
    return parts


def _vase_profile(dice: Dice, height: float, radius: float) -> Points2:
    """Return the outside of a vase."""
    style = dice.pick(free=0.45, amphora=0.15, trumpet=0.15, gourd=0.12, bowl=0.13)
    shares = {
        "free": [dice.between(0.35, 0.7), *(dice.between(0.4, 1.0) for _ in range(dice.count(2, 4))), dice.between(0.35, 0.9)],
        "amphora": [0.28, 0.7, 1.0, 0.95, 0.4, dice.between(0.28, 0.4), dice.between(0.4, 0.6)],
        "trumpet": [dice.between(0.35, 0.6), 0.3, dice.between(0.3, 0.4), 0.5, 1.0],
        "gourd": [0.5, 1.0, dice.between(0.4, 0.55), 0.7, 0.65, 0.3],
        "bowl": [0.4, 0.85, 1.0, 1.0, dice.between(0.85, 1.05)],
    }[style]
    knots = np.column_stack([np.array(shares) * radius, np.linspace(0, height * (0.6 if style == "bowl" else 1.0), len(shares))])
    line = smooth(knots, 22)
    line[:, 0] = line[:, 0].clip(0.15 * radius)
    line[:, 1] *= height / line[-1, 1]
    return line


def _fluted(part: Part, lobes: int, depth: float, twist: float) -> Part:
    """Return the part with its radius waved around the axis, the waves turning by ``twist`` radians per metre of height."""
    x, y, z = part.vertices.T
    factor = 1 + depth * np.cos(lobes * np.arctan2(y, x) + twist * z)
    return Part(np.column_stack([x * factor, y * factor, z]), part.faces)

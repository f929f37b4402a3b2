"""Mugs: handle behind, at -x."""

from math import pi

import numpy as np

from viewgain.arrays import Points2
from viewgain.shapes._assemble import Parts
from viewgain.shapes._dice import Dice
from viewgain.shapes._ear import ear
from viewgain.shapes._lathe import hollow, lathe
from viewgain.shapes._outline import superellipse
from viewgain.shapes._path import rounded, smooth
from viewgain.shapes._primitives import ellipsoid, torus
from viewgain.shapes._sweep import rod, sweep


def mug(dice: Dice) -> Parts:
    """Return a mug: 0.075 to 0.14 m high, 0.064 to 0.092 m across the foot; uniform.

    Wall: straight or curved (40 % each), stepped; round (80 %) or of 5 to 10 sides. Handle: ear (40 %), square (20 %), ring (15
    %), hook, none, two ears. 1 to 3 bands (25 %); a lid or a spoon (15 % each) or a saucer (10 %).
    """
    height, radius = dice.between(0.075, 0.14), dice.between(0.032, 0.046)
    profile = _mug_wall(dice, height, radius)
    sides = dice.count(5, 10) if dice.chance(0.2) else dice.count(12, 18) * 2
    parts = [lathe(hollow(profile, dice.between(0.08, 0.14) * radius, 0.06 * height), sides)]
    parts += _mug_handle(dice, height, profile * (float(np.cos(pi / sides)), 1.0), radius)
    for k in range(dice.count(1, 3) if dice.chance(0.25) else 0):
        z = (0.15 + 0.3 * k) * height
        parts.append(torus(float(np.interp(z, profile[:, 1], profile[:, 0])), 0.05 * height, 28, 8).at(z=z))
    return parts + _mug_extra(dice, height, radius, rim=float(profile[-1, 0]))


def _mug_wall(dice: Dice, height: float, radius: float) -> Points2:
    """Return the outside of a mug, from foot to rim."""
    top, belly = dice.between(0.85, 1.2) * radius, dice.between(0.8, 1.25) * radius
    style = dice.pick(straight=0.4, curved=0.4, stepped=0.2)
    if style == "curved":
        return smooth([(0.8 * radius, 0.0), (belly, 0.35 * height), (0.5 * (belly + top), 0.75 * height), (top, height)], 14)
    if style == "stepped":
        step = dice.between(0.25, 0.6)
        return np.array([(0.9, 0.0), (1.0, 0.04), (1.0, step), (0.9, step + 0.02), (0.9, 1.0)]) * (radius, height)
    share = top / radius
    return np.array([(0.92, 0.0), (1.0, 0.03), ((1 + share) / 2, 0.5), (0.98 * share, 0.97), (share, 1.0)]) * (radius, height)


def _mug_extra(dice: Dice, height: float, radius: float, rim: float) -> Parts:
    """Return a lid, a spoon, a saucer or nothing."""
    extra = dice.pick(none=0.6, lid=0.15, spoon=0.15, saucer=0.1)
    if extra == "lid":
        lid = lathe([(1.05 * rim, height), (1.05 * rim, 1.04 * height), (0.3 * rim, 1.1 * height)], 28)
        return [lid, ellipsoid(0.4 * rim, 0.4 * rim, 0.4 * rim).at(z=1.13 * height)]
    if extra == "spoon":
        end = (0.75 * radius, 0.1 * radius, 1.35 * height)
        bowl = ellipsoid(0.35 * radius, 0.3 * radius, 0.1 * radius, 5, 10).turned(-1.1, "y")
        return [rod((-0.2 * radius, 0.2 * radius, 0.1 * height), end, 0.05 * radius), bowl.at(*end)]
    if extra == "saucer":
        plate = [(radius, -0.06 * height), (1.5 * radius, 0.0), (2.0 * radius, 0.1 * height)]
        return [lathe(hollow(plate, 0.1 * radius, 0.08 * height), 36)]
    return []


def _mug_handle(dice: Dice, height: float, profile: Points2, radius: float) -> Parts:
    """Return the handle behind a mug whose flat sides have the given profile; it ends inside the wall."""
    style = dice.pick(ear=0.4, ring=0.15, square=0.2, hook=0.1, two=0.07, none=0.08)
    low, edge, high = (float(np.interp(share * height, profile[:, 1], profile[:, 0])) for share in (0.22, 0.5, 0.82))
    r, out, flat = 0.13 * radius, max(low, high) + dice.between(0.5, 0.9) * radius, dice.between(1.0, 1.8)
    if style == "none":
        return []
    if style == "ring":
        size = dice.between(0.26, 0.36) * height
        return [torus(size, 2 * r, 24, 8).turned(pi / 2, "x").at(-edge - 0.93 * size, z=0.5 * height)]
    if style == "square":
        path = rounded(
            [
                (-0.97 * high, 0, 0.82 * height),
                (-out, 0, 0.82 * height),
                (-out, 0, 0.22 * height),
                (-0.97 * low, 0, 0.22 * height),
            ],
            0.25 * radius,
        )
        return [sweep(path, superellipse(2 * r * flat, 2 * r, 4.0, 12))]
    if style == "hook":
        return [
            ear(
                [
                    (0.97 * high, 0.82 * height),
                    (out, 0.85 * height),
                    (1.02 * out, 0.5 * height),
                    (0.7 * out + 0.3 * edge, 0.25 * height),
                ],
                r,
                flat,
            )
        ]
    handle = ear([(0.97 * high, 0.82 * height), (out, 0.78 * height), (out, 0.42 * height), (0.97 * low, 0.22 * height)], r, flat)
    return [handle, handle.turned(pi)] if style == "two" else [handle]

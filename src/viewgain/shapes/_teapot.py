"""Teapots: spout towards +x, handle behind."""

from math import pi

import numpy as np

from viewgain.shapes._assemble import Parts
from viewgain.shapes._dice import Dice
from viewgain.shapes._ear import ear
from viewgain.shapes._lathe import lathe
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._path import arc, smooth
from viewgain.shapes._primitives import ellipsoid, frustum, torus
from viewgain.shapes._sweep import sweep


def teapot(dice: Dice) -> Parts:
    """Return a teapot: body 0.10 to 0.18 m across, 0.7 to 1.3 times as high; uniform.

    Body: ball (35 %), pear or drum (20 % each), can (15 %), cone; round (80 %) or of 6 to 10 sides. Spout curved (60 %) or
    straight; handle behind (70 %) or a bail over the top; knob ball, cone or ring; three feet (25 %).
    """
    radius, squat = dice.between(0.05, 0.09), dice.between(0.7, 1.3)
    height, rim = 2 * radius * squat, radius * dice.between(0.4, 0.62)
    style = dice.pick(ball=0.35, pear=0.2, drum=0.2, can=0.15, cone=0.1)
    shares = {
        "ball": [0.6, 0.95, 1.0, 0.85],
        "pear": [0.7, 1.0, 0.85, 0.6],
        "drum": [0.92, 1.0, 1.0, 0.97],
        "can": [0.9, 0.88, 0.8, 0.72],
        "cone": [1.0, 0.88, 0.74, 0.6],
    }[style]
    if style == "can":
        height *= 1.4
    knots = [(share * radius, height * k / 3.4) for k, share in enumerate(shares)]
    profile = smooth([*knots, (rim, height)], 18)
    sides = dice.count(6, 10) if dice.chance(0.2) else dice.count(12, 16) * 2
    parts = [lathe(profile, sides), *_lid(dice, height, rim), *_spout(dice, height, radius)]
    r = dice.between(0.09, 0.14) * radius
    if dice.chance(0.3):
        turn = arc(radius * 0.92, 0.15, pi - 0.15, 15)
        bail = np.column_stack([turn[:, 0], np.zeros(15), 0.72 * height + turn[:, 1] * dice.between(1.3, 1.8)])
        parts.append(sweep(bail, unit_circle(8) * r))
    else:
        out = radius * dice.between(1.6, 1.95)
        parts.append(
            ear([(0.8 * radius, 0.86 * height), (out, 0.9 * height), (out, 0.5 * height), (0.85 * radius, 0.22 * height)], r, 1.4)
        )
    if dice.chance(0.25):
        parts += [
            ellipsoid(0.3 * radius, 0.3 * radius, 0.3 * radius, 5, 10).at(
                0.55 * radius * np.cos(a), 0.55 * radius * np.sin(a), -0.02 * height
            )
            for a in (0.0, 2.1, 4.2)
        ]
    return parts


def _spout(dice: Dice, height: float, radius: float) -> Parts:
    """Return the spout: a tapering tube, curved like an S or straight."""
    reach, up = radius * dice.between(1.7, 2.1), dice.between(0.85, 1.05) * height
    if dice.chance(0.6):
        path = smooth(
            [
                (0.7 * radius, 0, 0.28 * height),
                (1.25 * radius, 0, 0.4 * height),
                (0.55 * reach + 0.6 * radius, 0, 0.75 * up),
                (reach, 0, up),
            ],
            12,
        )
    else:
        path = np.linspace((0.7 * radius, 0, dice.between(0.35, 0.55) * height), (reach, 0, up), 6)
    return [sweep(path, unit_circle(10) * radius, scale=np.linspace(0.3, dice.between(0.1, 0.14), len(path)))]


def _lid(dice: Dice, height: float, rim: float) -> Parts:
    """Return lid and knob over a mouth of radius ``rim``."""
    tall = dice.between(0.15, 0.5) * rim
    lid = lathe(
        [
            (1.08 * rim, height - 0.03 * rim),
            (1.08 * rim, height + 0.05 * rim),
            (0.7 * rim, height + 0.7 * tall),
            (0.15 * rim, height + tall),
        ],
        24,
    )
    top, knob = height + tall, dice.pick(ball=0.5, cone=0.25, ring=0.25)
    if knob == "ball":
        return [lid, ellipsoid(0.45 * rim, 0.45 * rim, 0.45 * rim).at(z=top + 0.15 * rim)]
    if knob == "cone":
        return [lid, frustum(0.12 * rim, 0.3 * rim, 0.4 * rim, 12).at(z=top - 0.03 * rim)]
    return [lid, torus(0.25 * rim, 0.12 * rim, 16, 8).turned(pi / 2, "x").at(z=top + 0.25 * rim)]

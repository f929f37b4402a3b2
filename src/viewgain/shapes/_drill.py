"""Hand drills: bit towards +x, standing on the grip or the battery."""

from math import pi

import numpy as np

from viewgain.shapes._assemble import Parts
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import lathe
from viewgain.shapes._outline import superellipse, unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import smooth
from viewgain.shapes._primitives import board, ellipsoid, torus
from viewgain.shapes._sweep import rod, sweep


def drill(dice: Dice) -> Parts:
    """Return a hand drill: body 0.11 to 0.17 m long, bit 0.04 to 0.12 m, grip 0.11 to 0.16 m; uniform.

    Power: battery shoe (50 %), battery in the grip or cable (25 % each). Side handle (25 %), hand guard (20 %), 0 to 4 vents,
    belt clip (30 %); body of 12 to 20 sides, chuck of 8 to 18.
    """
    radius, body = dice.between(0.024, 0.034), dice.between(0.11, 0.17)
    x, lean, drop = dice.between(-0.3, 0.0) * body, dice.between(0.05, 0.3), dice.between(0.11, 0.16)
    foot = (x - lean * drop, -drop)
    grip = smooth([(x, 0, 0), (x + 0.006 - 0.4 * lean * drop, 0, -0.4 * drop), (foot[0], 0, foot[1])], 8)
    section, swell = superellipse(1.35 * radius, 1.6 * radius, 3.0, 16), [1.1, 0.95, 0.88, 0.9, 0.92, 0.95, 1.0, 1.05]
    trigger = ellipsoid(0.7 * radius, 0.6 * radius, 1.3 * radius, 6, 10).at(x + 0.95 * radius, z=-1.5 * radius)
    parts = [*_barrel(dice, radius, body), sweep(grip, section, scale=swell, up=(1.0, 0.0, 0.0)), trigger]
    return [*parts, _power(dice, radius, foot), *_drill_extras(dice, radius, body, x, foot)]


def _barrel(dice: Dice, radius: float, body: float) -> Parts:
    """Return motor housing, chuck and bit, along x."""
    profile = [(dice.between(0.6, 0.9), -0.5), (1.0, -0.42), (1.0, 0.2), (0.85, 0.3), (0.8, 0.42), (0.55, 0.5)]
    hull = lathe(np.array(profile) * (radius, body), dice.count(6, 10) * 2).turned(pi / 2, "y")
    front, chuck = 0.5 * body, dice.between(0.03, 0.05)
    jaws = np.array([(0.66, 0.0), (0.7, 0.5), (0.62, 0.55), (0.25, 1.0)]) * (radius, chuck)
    nose = lathe(jaws, dice.count(4, 9) * 2).turned(pi / 2, "y").at(front - 0.002)
    tip = front + chuck + dice.between(0.04, 0.12)
    return [hull, nose, rod((front, 0.0, 0.0), (tip, 0.0, 0.0), dice.between(0.0025, 0.006), sides=6)]


def _power(dice: Dice, radius: float, foot: tuple[float, float]) -> Part:
    """Return the battery or the cable at the foot of the grip, given as (x, z)."""
    x, z = foot
    power = dice.pick(shoe=0.5, grip=0.25, cable=0.25)
    if power == "shoe":
        return board(dice.between(0.09, 0.13), 2.1 * radius, dice.between(0.03, 0.05), 0.006).at(x + 0.015, z=z - 0.03)
    if power == "grip":
        return board(2.0 * radius, 1.7 * radius, 0.03, 0.004).at(x, z=z - 0.025)
    cord = smooth([(x, 0, z), (x - 0.01, 0, z - 0.03), (x - 0.06, 0, z - 0.045), (x - 0.12, 0.03, z - 0.04)], 12)
    return sweep(cord, unit_circle(8) * 0.004)


def _drill_extras(dice: Dice, radius: float, body: float, x: float, foot: tuple[float, float]) -> Parts:
    """Return side handle, guard, vents and clip, each with its own chance."""
    parts: Parts = []
    if dice.chance(0.25):
        y = 0.09 + radius
        parts += [
            torus(0.92 * radius, 0.3 * radius, 18, 8).turned(pi / 2, "y").at(0.36 * body),
            rod((0.36 * body, 0.8 * radius, 0.0), (0.36 * body, y, 0.0), 0.4 * radius, 0.5 * radius, 12),
        ]
    if dice.chance(0.2):
        guard = smooth(
            [
                (x + 1.2 * radius, 0, -0.6 * radius),
                (x + 1.9 * radius, 0, 0.5 * foot[1]),
                (foot[0] + 0.4 * radius, 0, 0.95 * foot[1]),
            ],
            9,
        )
        parts.append(sweep(guard, unit_circle(8) * 0.006))
    for k in range(dice.count(0, 4)):
        parts.append(board(0.004, 2.06 * radius, 0.9 * radius, 0.001).at((k * 0.06 - 0.44) * body + 0.01, z=-0.45 * radius))
    if dice.chance(0.3):
        parts.append(board(0.05, 0.01, 0.02, 0.003).at(-0.1 * body, 1.05 * radius, -0.01))
    return parts

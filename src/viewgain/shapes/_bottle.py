"""Bottles."""

from math import pi

import numpy as np

from viewgain.arrays import Points2
from viewgain.shapes._assemble import Parts
from viewgain.shapes._dice import Dice
from viewgain.shapes._ear import ear
from viewgain.shapes._lathe import hollow, lathe
from viewgain.shapes._outline import superellipse, unit_circle
from viewgain.shapes._path import rounded, smooth
from viewgain.shapes._primitives import cylinder, frustum
from viewgain.shapes._sweep import sweep


def bottle(dice: Dice) -> Parts:
    """Return a bottle: body 0.14 to 0.32 m high, 0.034 to 0.11 m across; uniform.

    Shoulder: round (35 %), sloping (25 %), square or waisted (20 % each). Body: round (70 %), 4 to 8 flat sides (20 %) or oval; 2
    to 6 ribs on a third. Top: cap (30 %), open lip or pump (20 % each), cork or trigger spray (15 % each). A grip on 20 %.
    """
    height, radius = dice.between(0.14, 0.32), dice.between(0.026, 0.055)
    radius = min(max(radius, 0.12 * height), 0.3 * height)
    neck = radius * dice.between(0.28, 0.5)
    sides, oval = dice.count(9, 16) * 2, 1.0
    style = dice.pick(round=0.7, flat=0.2, oval=0.1)
    if style == "flat":
        sides = dice.count(4, 8)
    elif style == "oval":
        oval = dice.between(0.55, 0.75)
    profile = _bottle_profile(dice, height, radius, neck)
    top = dice.pick(lip=0.2, cap=0.3, cork=0.15, pump=0.2, spray=0.15)
    if top == "lip":
        profile = hollow(profile, 0.12 * neck, 0.02 * height)
    body = lathe(profile, sides).stretched(y=oval)
    parts = [body, *_closure(dice, top, neck * 1.12, height)]
    if dice.chance(0.2) and style != "oval":
        parts.append(
            ear([(0.85 * radius, 0.45 * height), (1.7 * radius, 0.6 * height), (0.6 * neck, 0.9 * height)], 0.13 * radius)
        )
    return parts


def _bottle_profile(dice: Dice, height: float, radius: float, neck: float) -> Points2:
    """Return the outside of a bottle, from foot to rim."""
    shoulder, mouth = dice.between(0.5, 0.72) * height, dice.between(0.78, 0.88) * height
    style = dice.pick(round=0.35, slope=0.25, square=0.2, waist=0.2)
    foot = [(0.9 * radius, 0.0), (radius, 0.025 * height)]
    if style == "waist":
        knots = [(0.93 * radius, 0.02 * height), (radius, 0.15 * height), (dice.between(0.65, 0.85) * radius, 0.4 * height)]
        body = smooth([*knots, (radius, shoulder), (1.2 * neck, 0.96 * mouth), (neck, mouth)], 20)
    else:
        ribs = dice.count(2, 6) if dice.chance(0.35) else 0
        side = [(radius * (0.93 if k % 2 else 1.0), (0.12 + 0.8 * k / (2 * ribs)) * shoulder) for k in range(2 * ribs)]
        bend = {"round": 0.9, "slope": 0.55, "square": 0.98}[style]
        curve = smooth([(radius, shoulder), (neck + bend * (radius - neck), 0.45 * shoulder + 0.55 * mouth), (neck, mouth)], 9)
        if style == "square":
            curve = np.array([(radius, 0.92 * mouth), (0.93 * radius, 0.95 * mouth), (1.1 * neck, 0.985 * mouth), (neck, mouth)])
        body = np.array([*side, *curve])
    lip = [(neck, 0.95 * height), (1.15 * neck, 0.955 * height), (1.15 * neck, height)]
    return np.array([*foot, *body, *lip])


def _closure(dice: Dice, style: str, neck: float, height: float) -> Parts:
    """Return what closes the mouth, at z = ``height``."""
    if style == "lip":
        return []
    if style == "cork":
        return [frustum(0.75 * neck, 0.85 * neck, 0.07 * height, 14).at(z=height - 0.02 * height)]
    cap = cylinder(1.25 * neck, 0.08 * height, dice.count(6, 12) * 2).at(z=height - 0.05 * height)
    if style == "cap":
        return [cap]
    stem = cylinder(0.3 * neck, 0.12 * height, 8).at(z=height)
    z, r = 1.12 * height, 0.2 * neck
    if style == "pump":
        nozzle = rounded([(-0.3 * neck, 0, z), (2.0 * neck, 0, z), (2.6 * neck, 0, z - 0.6 * neck)], 0.5 * neck)
        return [cap, stem, cylinder(0.8 * neck, 0.3 * neck, 12).at(z=z - 0.1 * neck), sweep(nozzle, unit_circle(8) * r)]
    head = sweep(
        [(-1.3 * neck, 0, z), (0.6 * neck, 0, z), (2.2 * neck, 0, z)],
        superellipse(1.5 * neck, 1.4 * neck, 3.0, 16),
        scale=[0.8, 1.0, 0.6],
    )
    trigger = smooth([(1.2 * neck, 0, z), (1.3 * neck, 0, z - 1.4 * neck), (1.9 * neck, 0, z - 2.8 * neck)], 7)
    return [
        cap,
        stem,
        head,
        sweep(trigger, superellipse(0.9 * neck, 0.35 * neck, 3.0, 10)),
        cylinder(0.3 * neck, 0.3 * neck, 8).turned(pi / 2, "y").at(2.1 * neck, z=z),
    ]

"""Hammers: lying on the floor, head at +x."""

from math import pi

import numpy as np

from viewgain.shapes._assemble import Parts, shifted
from viewgain.shapes._dice import Dice
from viewgain.shapes._extrude import extrude
from viewgain.shapes._lathe import lathe
from viewgain.shapes._outline import ellipse, rectangle, superellipse, unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import rounded_loop, smooth
from viewgain.shapes._primitives import board, cylinder, ellipsoid, tapered, torus
from viewgain.shapes._sweep import sweep


def hammer(dice: Dice) -> Parts:
    """Return a hammer: handle 0.25 to 0.4 m long (sledge and pick 0.5 to 0.9 m); uniform.

    Heads: claw (25 %), ball peen, cross peen and mallet (15 % each; mallets round or square), sledge (12 %), hatchet (10 %), pick
    (8 %). Handle: straight, swelling or waisted, of 8 to 16 sides, with a grip of 0 to 5 rings (40 %), a pommel (24 %) or plain.
    """
    kind = dice.pick(claw=0.25, ball=0.15, cross=0.15, sledge=0.12, mallet=0.15, hatchet=0.1, pick=0.08)
    long = dice.between(0.5, 0.9) if kind in ("sledge", "pick") else dice.between(0.25, 0.4)
    least, most = {"sledge": (0.05, 0.07), "mallet": (0.06, 0.09)}.get(kind, (0.026, 0.036))
    size = dice.between(least, most)
    parts = _handle(dice, long, min(0.45 * size, 0.017) if kind != "sledge" else 0.02)
    parts += shifted(_hammer_head(dice, kind, size), long / 2)
    return parts


def _handle(dice: Dice, long: float, thick: float) -> Parts:
    """Return a handle along x, centred on the origin."""
    style = dice.pick(straight=0.3, swelling=0.4, waisted=0.3)
    shares = {"straight": [1.0, 1.0, 1.0, 1.0], "swelling": [1.3, 1.2, 0.75, 0.85], "waisted": [1.25, 0.85, 1.15, 0.8]}[style]
    path = np.column_stack([np.linspace(-long / 2, long / 2 + 0.5 * thick, 12), np.zeros((12, 2))])
    sides = dice.count(4, 8) * 2
    parts = [sweep(path, ellipse(2.0 * thick, 1.5 * thick, sides), scale=smooth([[share] for share in shares], 12)[:, 0])]
    if dice.chance(0.4):
        parts.append(sweep(path[:5], superellipse(2.7 * thick, 2.2 * thick, 2.6, 16), scale=[1.1, 1.05, 1.0, 1.0, 0.95]))
        ring = torus(1.35 * thick, 0.4 * thick, 16, 6).turned(pi / 2, "y").stretched(z=0.85)
        parts += [ring.at((k + 1) * 0.055 * long - long / 2) for k in range(dice.count(0, 5))]
    elif dice.chance(0.4):
        parts.append(ellipsoid(2.6 * thick, 3.4 * thick, 2.4 * thick).at(-long / 2))
    return parts


def _hammer_head(dice: Dice, kind: str, size: float) -> Parts:
    """Return the head about the origin, its striking face towards +y."""
    if kind == "sledge":
        return [_barrel(8, 1.08 * size, dice.between(2.2, 3.0) * size, 0.15 * size)]
    if kind == "mallet":
        wide = dice.between(1.5, 2.0) * size
        return [
            board(0.9 * size, wide, size, 0.1 * size).at(z=-size / 2)
            if dice.chance(0.5)
            else _barrel(24, size, wide, 0.05 * size)
        ]
    block = board(1.1 * size, 1.3 * size, size).at(z=-size / 2)
    if kind == "pick":
        return [block, _pick(dice, size)]
    profile = [(0.43, 0.0), (0.35, 0.5), (0.36, 0.9), (0.53, 1.0), (0.53, 1.5), (0.48, 1.6)]
    face = lathe(np.array(profile) * size, dice.count(4, 10) * 2).turned(-pi / 2, "x")
    peen = {"claw": _claw, "ball": _ball, "cross": _cross, "hatchet": _hatchet}[kind](dice, size)
    return [face, block, *peen]


def _barrel(sides: int, size: float, wide: float, bevel: float) -> Part:
    """Return a prism along y, ``size`` thick, one of its sides upwards."""
    return extrude(unit_circle(sides) * size / 2, wide, bevel=bevel).turned(pi / sides).turned(pi / 2, "x").at(y=wide / 2)


def _claw(dice: Dice, size: float) -> Parts:
    """Return two prongs that bend back towards the handle."""
    path = smooth(np.array([(0.0, -0.3, 0.0), (0.05, -1.0, 0.0), (-0.25, -2.0, 0.0), (-0.9, -2.7, 0.0)]) * size, 10)
    taper = np.linspace((1.2, 1.0), (dice.between(0.2, 0.5), 0.9), 10)
    prong = sweep(path, superellipse(0.4 * size, 0.5 * size, 4.0, 12), scale=taper, up=(1.0, 0.0, 0.0))
    return [prong.at(z=0.21 * size), prong.at(z=-0.21 * size)]


def _ball(dice: Dice, size: float) -> Parts:
    """Return a ball on a short neck."""
    ball = dice.between(0.85, 1.05) * size
    return [
        cylinder(0.33 * size, size, 14).turned(pi / 2, "x").at(y=-0.3 * size),
        ellipsoid(ball, ball, ball, 10, 18).at(y=-1.5 * size),
    ]


def _cross(dice: Dice, size: float) -> Parts:
    """Return a wedge across the handle."""
    edge = dice.between(0.15, 0.3) * size
    return [tapered((1.1 * size, size), (size, edge), 1.5 * size).turned(pi / 2, "x").at(y=-0.4 * size)]


def _hatchet(dice: Dice, size: float) -> Parts:
    """Return a blade that widens to its edge, towards -y."""
    blade = np.array([(0.0, -0.6), (-1.4, -3.2), (0.0, -3.6), (1.0, -3.2), (0.7, -0.6)]) * (size, dice.between(0.9, 1.1) * size)
    axe = extrude(rounded_loop(blade, 0.3 * size), 0.5 * size, bevel=0.2 * size, centre=(-0.05 * size, -2.2 * size))
    return [axe.at(z=-0.25 * size)]


def _pick(dice: Dice, size: float) -> Part:
    """Return a long bow across the handle, pointed at both ends or broad at one."""
    path = smooth(np.array([(-1.6, 6.0, 0.0), (0.0, 2.5, 0.0), (0.15, 0.0, 0.0), (0.0, -2.5, 0.0), (-1.6, -6.0, 0.0)]) * size, 17)
    thin = np.interp(np.linspace(-1, 1, 17), [-1, 0, 1], [0.25, 1.0, 0.25])
    broad = np.interp(np.linspace(-1, 1, 17), [-1, 0, 1], [0.25 if dice.chance(0.5) else 0.9, 1.0, 0.25])
    return sweep(path, rectangle(size, size, 0.2 * size, 2), scale=np.column_stack([broad, thin]))

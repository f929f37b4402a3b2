"""Guitars: standing on the lower bout, front towards +x."""

from math import pi

import numpy as np

from viewgain.arrays import Points2
from viewgain.shapes._assemble import Parts, both_sides, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._extrude import extrude, front_profile
from viewgain.shapes._outline import ellipse, rectangle
from viewgain.shapes._path import rounded_loop, smooth
from viewgain.shapes._primitives import board, cylinder, ellipsoid, tapered
from viewgain.shapes._sweep import rod


def guitar(dice: Dice) -> Parts:
    """Return a guitar: 0.92 to 1.12 m high (ukulele 0.55 to 0.7 m), 0.038 to 0.13 m deep; uniform.

    Kinds: acoustic (35 %), solid with two horns (20 %) or one (13 %), ukulele (12 %), V or star (10 %), banjo (10 %). Headstock:
    tuners on both sides (50 %), in line (30 %), slotted (20 %); 4 to 8 strings, drawn on 70 %; 5 to 14 frets, 0 to 3 pickups, 0
    to 4 knobs.
    """
    kind = dice.pick(acoustic=0.35, ukulele=0.12, double=0.2, single=0.13, vee=0.1, banjo=0.1)
    whole = dice.between(0.55, 0.7) if kind == "ukulele" else dice.between(0.92, 1.12)
    tall = whole * dice.between(0.42, 0.48)
    hollow = kind in ("acoustic", "ukulele", "banjo")
    deep = dice.between(0.075, 0.12) * (whole if kind == "acoustic" else 0.8) if hollow else dice.between(0.038, 0.05)
    body = _body(dice, kind, tall)
    parts = [front_profile(body, deep, bevel=0.004 if hollow else 0.009, centre=(0.0, 0.45 * tall))]
    if kind == "banjo":
        parts += _banjo_rim(dice, tall, deep)
    strings = 4 if kind in ("ukulele", "banjo") else dice.count(4, 8)
    top = 0.94 * tall if kind not in ("double", "vee") else 0.8 * tall
    parts += _neck(dice, top, whole - 0.17 * whole, deep, strings, frets=dice.count(5, 14))
    parts += _headstock(dice, whole * 0.83, whole, deep, strings)
    parts += _fittings(dice, kind, tall, deep, hollow=hollow)
    bridge = 0.24 * tall
    wires = [
        rod((deep + 0.012, y, bridge), (deep + 0.006, 0.8 * y, 0.85 * whole), 0.0012, sides=4) for y in spread(strings, 0.042)
    ]
    return parts + wires if dice.chance(0.7) else parts


def _body(dice: Dice, kind: str, tall: float) -> Points2:
    """Return the outline of the body in (y, z), counter-clockwise, its lowest point near z = 0."""
    wide, upper, waist = tall * dice.between(0.38, 0.44), dice.between(0.68, 0.84), dice.between(0.55, 0.68)
    if kind == "banjo":
        return np.asarray(ellipse(0.62 * tall, 0.62 * tall, 36) + np.array((0.0, 0.45 * tall)))
    if kind == "vee":
        star = [
            (0.0, 0.18),
            (0.4, 0.0),
            (0.2, 0.45),
            (0.36, 0.95),
            (0.06, 0.75),
            (-0.06, 0.75),
            (-0.32, 0.9),
            (-0.2, 0.45),
            (-0.44, 0.02),
        ]
        arrow = [(0.0, 0.3), (0.4, 0.0), (0.46, 0.1), (0.04, 0.86), (-0.04, 0.86), (-0.46, 0.1), (-0.4, 0.0)]
        corners = np.array(star if dice.chance(0.4) else arrow) * tall
        return rounded_loop(corners, 0.04 * tall)
    right = [
        (0.0, 0.0),
        (0.62, 0.03),
        (1.0, 0.24),
        (0.9, 0.42),
        (waist, 0.57),
        (0.95 * upper, 0.72),
        (0.93 * upper, 0.88),
        (0.4, 0.985),
        (0.0, 0.99),
    ]
    left = [(-y, z) for y, z in right[::-1]][1:]
    if kind in ("double", "single"):
        horn = [(0.82 * upper, 0.86), (dice.between(0.6, 0.75), dice.between(1.0, 1.1)), (0.3, 0.9), (0.18, 0.8), (0.0, 0.8)]
        right = [*right[:6], *horn]
        left = [(-y, z) for y, z in right[::-1]][1:] if kind == "double" else [(-0.2, 0.95), *left[1:]]
    line = smooth([(y * wide, z * tall) for y, z in (*right, *left)], 52)
    return line[:-1]


def _banjo_rim(dice: Dice, tall: float, deep: float) -> Parts:
    """Return the brackets around a banjo's drum."""
    count, r = dice.count(8, 20), 0.315 * tall
    angle = np.arange(count) * (2 * pi / count)
    return [
        rod(
            (0.1 * deep, r * np.cos(a), 0.45 * tall + r * np.sin(a)),
            (0.95 * deep, r * np.cos(a), 0.45 * tall + r * np.sin(a)),
            0.005,
            sides=6,
        )
        for a in angle
    ]


def _neck(dice: Dice, low: float, high: float, deep: float, strings: int, *, frets: int) -> Parts:
    """Return the neck with its fingerboard and frets, and the heel."""
    wide, thick = 0.038 + 0.0035 * strings, 0.022
    x = deep - 0.5 * thick + 0.004
    foot = 0.7 * low
    neck = tapered((thick, 1.15 * wide), (thick, 0.9 * wide), high - foot).at(x, z=foot)
    heel = tapered((0.5 * deep, 0.9 * wide), (0.8 * deep, 0.9 * wide), 0.1 * low).at(0.55 * deep, z=0.9 * low)
    bar = board(0.004, wide, 0.003, 0.0005)
    return [neck, heel, *(bar.at(x + 0.5 * thick, z=high - (high - foot) * (1 - 0.92 ** (k + 1)) * 1.2) for k in range(frets))]


def _headstock(dice: Dice, low: float, high: float, deep: float, strings: int) -> Parts:
    """Return the head with its tuners, leaning back a little."""
    long, wide = high - low, dice.between(0.065, 0.09)
    style = dice.pick(sides=0.5, line=0.3, slotted=0.2)
    x, lean = deep - 0.012, dice.between(0.05, 0.25)
    if style == "line":
        corners = [(-0.3, 0.0), (0.3, 0.0), (0.45, 0.3), (0.5, 0.9), (0.2, 1.0), (-0.3, 0.95), (-0.5, 0.15)]
        outline = np.array(corners) * (wide, long)
        count, places = strings, [(-1.0, z) for z in spread(strings, 0.62 * long)]
    else:
        outline = rectangle(wide, long, dice.between(0.004, 0.03), 3) + np.array((0.0, 0.5 * long))
        count = (strings + 1) // 2
        places = [(side, z) for side in (1.0, -1.0) for z in spread(count, 0.6 * long)]
    parts = [front_profile(outline, 0.015, centre=(0.0, 0.5 * long))]
    if style == "slotted":
        parts += both_sides([board(0.017, 0.012, 0.66 * long).at(0.0075, 0.2 * wide, 0.15 * long)])
    for side, z in places:
        y = 0.5 * wide if style != "line" else (0.4 - 0.25 * z / long) * wide
        peg = [
            rod((0.0075, side * 0.7 * y, z), (0.0075, side * (y + 0.022), z), 0.003, sides=6),
            ellipsoid(0.012, 0.018, 0.016, 4, 8).at(0.0075, side * (y + 0.026), z),
        ]
        parts += [
            part.at(z=0.5 * long) for part in (*peg, cylinder(0.004, 0.026, 8).turned(pi / 2, "y").at(0.0, side * 0.6 * y, z))
        ]
    return [part.turned(-lean, "y").at(x - 0.0075, z=low - 0.01) for part in parts]


def _fittings(dice: Dice, kind: str, tall: float, deep: float, *, hollow: bool) -> Parts:
    """Return what sits on the top: bridge, sound hole or pickups, knobs, guard, strap buttons."""
    bridge = board(0.012, 0.3 * tall if hollow else 0.09, 0.03).at(deep + 0.004, z=0.22 * tall)
    parts = [bridge, ellipsoid(0.016, 0.016, 0.016, 4, 8).at(deep / 2, z=0.0 if kind != "banjo" else 0.13 * tall)]
    if kind in ("acoustic", "ukulele"):
        hole = cylinder(0.11 * tall, 0.004, 28).turned(pi / 2, "y").at(deep - 0.001, z=0.66 * tall)
        parts.append(hole)
    pickups = 0 if kind == "banjo" or (hollow and dice.chance(0.85)) else dice.count(1, 3)
    for k in range(pickups):
        parts.append(board(0.014, 0.085, dice.between(0.022, 0.04), 0.003).at(deep + 0.003, z=(0.36 + 0.14 * k) * tall))
    if not hollow:
        for k in range(dice.count(1, 4)):
            parts.append(
                cylinder(0.011, 0.016, 10)
                .turned(pi / 2, "y")
                .at(deep - 0.002, 0.15 * tall + 0.02 * (k % 2), (0.32 - 0.055 * k) * tall)
            )
        if dice.chance(0.3):
            parts.append(rod((deep, 0.03, 0.24 * tall), (deep + 0.03, 0.1, 0.42 * tall), 0.0025, sides=6))
    if dice.chance(0.4):
        plate = extrude(ellipse(0.32 * tall, 0.14 * tall, 20), 0.003).turned(pi / 2, "y").turned(0.5, "x")
        parts.append(plate.at(deep - 0.001, 0.16 * tall, 0.5 * tall))
    return parts

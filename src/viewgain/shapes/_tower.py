"""Towers: front door towards +x."""

from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from viewgain.shapes._assemble import Parts, around, both_sides, shifted, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import lathe
from viewgain.shapes._primitives import block, board, cylinder, ellipsoid, frustum, torus, wedge
from viewgain.shapes._sweep import rod


def tower(dice: Dice) -> Parts:
    """Return a tower: 12 to 60 m high without mast, 4 to 25 m wide; uniform within each kind.

    Kinds: lighthouse and castle tower (18 % each), water tower on 4 to 8 legs (15 %), lattice mast (13 %), stepped high-rise,
    windmill with 4 to 6 sails, pagoda of 3 to 7 storeys (12 % each).
    """
    kind = dice.pick(lighthouse=0.18, castle=0.18, water=0.15, lattice=0.13, steps=0.12, windmill=0.12, pagoda=0.12)
    build = {
        "lighthouse": _lighthouse,
        "castle": _castle,
        "water": _water,
        "lattice": _lattice,
        "steps": _steps,
        "windmill": _windmill,
        "pagoda": _pagoda,
    }[kind]
    return build(dice)


def _lighthouse(dice: Dice) -> Parts:
    """Return a tapering shaft with a gallery and a lantern."""
    tall, foot = dice.between(15.0, 35.0), dice.between(2.8, 4.5)
    top, sides = foot * dice.between(0.5, 0.75), dice.count(4, 12) * 2
    shaft = lathe(
        [(1.15 * foot, 0.0), (foot, 0.03 * tall), (top, 0.9 * tall), (1.35 * top, 0.94 * tall), (1.35 * top, 0.96 * tall)], sides
    )
    posts = around(rod((1.3 * top, 0.0, 0.96 * tall), (1.3 * top, 0.0, 0.96 * tall + 1.1), 0.06, sides=6), dice.count(8, 16))
    rail = torus(1.3 * top, 0.14, 24, 6).at(z=0.96 * tall + 1.1)
    lamp = [
        cylinder(0.7 * top, 2.4, 12).at(z=0.96 * tall),
        lathe([(0.9 * top, 2.3), (0.5 * top, 3.2), (0.1 * top, 3.9)], 16).at(z=0.96 * tall),
    ]
    hut = (
        [board(5.0, 4.0, 3.0).at(foot + 2.0), wedge(4.6, 5.4, 1.8).turned(pi / 2).at(foot + 2.0, z=3.0)]
        if dice.chance(0.4)
        else []
    )
    return [shaft, *posts, rail, *lamp, *hut, *_slits(dice, foot, top, tall)]


def _slits(dice: Dice, foot: float, top: float, tall: float) -> Parts:
    """Return narrow windows winding up a round shaft."""
    parts = []
    for k in range(count := dice.count(2, 6)):
        share = (k + 1) / (count + 1)
        parts.append(board(0.5, 0.7, 1.2).at(foot + share * (top - foot) - 0.1, z=0.85 * share * tall).turned(1.1 * k))
    return parts


def _castle(dice: Dice) -> Parts:
    """Return a round or square keep with battlements, turrets or a pointed roof."""
    tall, r = dice.between(12.0, 26.0), dice.between(3.5, 6.0)
    square, merlons = dice.chance(0.4), dice.count(4, 8) * 2
    if square:
        body: Parts = [board(2 * r, 2 * r, tall), board(2.3 * r, 2.3 * r, 1.5).at(z=tall - 0.2)]
        tooth, edge = board(0.7, 1.1, 1.2), 1.15 * r - 0.35
        teeth = [tooth.at(edge, y, tall + 1.2).turned(k * pi / 2) for k in range(4) for y in spread(merlons // 2, 2 * edge)[:-1]]
    else:
        body = [lathe([(1.12 * r, 0.0), (r, 0.12 * tall), (r, 0.9 * tall), (1.18 * r, 0.97 * tall), (1.18 * r, tall + 1.3)], 24)]
        teeth = around(board(0.7, 1.0 * r / merlons * 3, 1.2).at(1.18 * r - 0.4, z=tall + 1.2), merlons)
    style = dice.pick(plain=0.4, cone=0.3, turrets=0.3)
    if style == "cone":
        body += [
            cylinder(0.75 * r, 3.0, 16).at(z=tall + 1.0),
            frustum(0.95 * r, 0.05 * r, dice.between(0.9, 1.8) * r, 16).at(z=tall + 3.9),
        ]
    elif style == "turrets":
        turret = [
            cylinder(0.28 * r, 0.45 * tall, 12).at(z=0.72 * tall),
            frustum(0.38 * r, 0.02 * r, 0.8 * r, 12).at(z=1.17 * tall),
        ]
        count = 4 if square else dice.count(3, 5)
        reach = 1.45 * r if square else 1.1 * r
        body += [part.at(reach).turned(pi / 4 + 2 * pi * k / count) for k in range(count) for part in turret]
    return [*body, *teeth, board(0.6, 2.0, 3.2).at(r if square else 1.05 * r), *_slits(dice, r, r, tall)]


def _water(dice: Dice) -> Parts:
    """Return a tank on legs with cross bracing."""
    tall, r, legs = dice.between(15.0, 30.0), dice.between(3.5, 6.5), dice.count(4, 8)
    tank = dice.pick(ball=0.3, drum=0.4, bowl=0.3)
    z, spread_out = 0.68 * tall, dice.between(1.0, 1.4)
    if tank == "ball":
        top = [ellipsoid(2 * r, 2 * r, 1.7 * r, 10, 20).at(z=z + 0.7 * r)]
    elif tank == "drum":
        top = [cylinder(r, 1.3 * r, 24).at(z=z), frustum(1.08 * r, 0.1 * r, 0.6 * r, 24).at(z=z + 1.28 * r)]
    else:
        shares = [(0.3, 0.0), (0.75, 0.3), (1.0, 0.9), (1.0, 1.5), (0.5, 1.8), (0.1, 1.9)]
        top = [lathe(np.array(shares) * r, 24).at(z=z)]
    leg = rod((spread_out * r, 0.0, 0.0), (0.8 * r, 0.0, z + 0.3 * r), 0.22, sides=8)
    parts = [*top, *around(leg, legs), cylinder(0.4, z + 0.2, 10)]
    for share in (0.35, 0.7)[: dice.count(0, 2)]:
        reach = r * (spread_out + share * (0.8 - spread_out))
        step = 2 * pi / legs
        parts += around(rod((reach, 0.0, share * z), (reach * cos(step), reach * sin(step), share * z), 0.1, sides=6), legs)
    return parts


def _lattice(dice: Dice) -> Parts:
    """Return a mast of 3 or 4 legs with 3 to 7 braced bays, with platforms or arms."""
    tall, legs, bays = dice.between(20.0, 55.0), dice.count(3, 4), dice.count(3, 7)
    foot, top, bow = dice.between(0.1, 0.2) * tall, 0.015 * tall, dice.between(1.0, 2.2)
    r = 0.008 * tall
    levels = [(k / bays, top + (foot - top) * (1 - k / bays) ** bow) for k in range(bays + 1)]
    step = 2 * pi / legs
    parts: Parts = []
    for (low, a), (high, b) in pairwise(levels):
        parts += around(rod((a, 0.0, low * tall), (b, 0.0, high * tall), r, sides=6), legs, pi / 4)
        parts += around(rod((a, 0.0, low * tall), (b * cos(step), b * sin(step), high * tall), 0.5 * r, sides=6), legs, pi / 4)
        parts += around(rod((b, 0.0, high * tall), (b * cos(step), b * sin(step), high * tall), 0.6 * r, sides=6), legs, pi / 4)
    if dice.chance(0.5):
        parts.append(rod((0.0, 0.0, 0.97 * tall), (0.0, 0.0, 1.12 * tall), 0.5 * r))
    if dice.chance(0.4):
        arms = [
            rod((0.0, 0.0, share * tall), (0.0, 0.16 * tall, share * tall), 0.9 * r, 0.4 * r, 6)
            for share in (0.78, 0.88, 0.97)[: dice.count(1, 3)]
        ]
        return parts + both_sides(arms)
    return [*parts, cylinder(levels[1][1] * 1.05, 0.02 * tall, 16).at(z=levels[1][0] * tall)]


def _steps(dice: Dice) -> Parts:
    """Return a high-rise of 2 to 6 set-back blocks with ribs and a mast."""
    tall, wide, count = dice.between(30.0, 60.0), dice.between(9.0, 16.0), dice.count(2, 6)
    parts, z = [], 0.0
    deep = wide * dice.between(0.7, 1.0)
    ribs = dice.count(3, 6)
    for k in range(count):
        share = 1 - 0.75 * k / count * dice.between(0.8, 1.0)
        rise = tall * (0.5 if k == 0 else 0.5 / (count - 1))
        parts.append(board(share * deep, share * wide, rise + 0.2, 0.2).at(z=z))
        rib = block(0.5, 0.5, rise)
        parts += both_sides([rib.at(x, share * wide / 2, z) for x in spread(ribs, 0.8 * share * deep)])
        parts += [rib.at(side * share * deep / 2, y, z) for side in (1, -1) for y in spread(ribs, 0.8 * share * wide)]
        z += rise
    return [*parts, rod((0.0, 0.0, z), (0.0, 0.0, z + dice.between(3.0, 10.0)), 0.3, 0.1)] if dice.chance(0.7) else parts


def _windmill(dice: Dice) -> Parts:
    """Return a tapering body with a cap and 4 to 6 sails towards +x."""
    tall, foot, sails = dice.between(12.0, 20.0), dice.between(3.5, 5.0), dice.count(4, 6)
    top, reach, hub = 0.6 * foot, dice.between(0.5, 0.65) * tall, 0.96 * tall
    x = top + 1.4
    body = lathe([(foot, 0.0), (top, 0.9 * tall), (1.05 * top, 0.92 * tall)], dice.count(6, 12))
    cap = ellipsoid(2.2 * top, 2.2 * top, 2.2 * top).at(z=0.92 * tall)
    shaft = rod((0.0, 0.0, hub), (x + 0.3, 0.0, hub), 0.35)
    spar = rod((x, 0.0, 0.0), (x, 0.0, reach), 0.16, 0.1)
    cloth = [board(0.08, 0.14 * reach, 0.72 * reach, 0.02).at(x + 0.05, 0.08 * reach, 0.25 * reach)]
    blade = [spar, *cloth]
    turn = dice.between(0.0, 1.5)
    turned_blades = [part.turned(turn + 2 * pi * k / sails, "x").at(z=hub) for k in range(sails) for part in blade]
    return [body, cap, shaft, *turned_blades, board(0.4, 1.4, 2.4).at(0.97 * foot), *_slits(dice, foot, top, tall)]


def _pagoda(dice: Dice) -> Parts:
    """Return 3 to 7 storeys, each with a roof that curves up at its edge."""
    storeys, wide, sides = dice.count(3, 7), dice.between(3.5, 5.5), dice.pick(four=0.5, six=0.2, eight=0.3)
    n, shrink, rise = {"four": 4, "six": 6, "eight": 8}[sides], dice.between(0.84, 0.92), dice.between(3.0, 3.8)
    parts, z = [], 0.0
    for _ in range(storeys):
        roof = lathe(
            [
                (1.0 * wide, rise - 0.3),
                (1.55 * wide, rise - 0.1),
                (1.6 * wide, rise + 0.1),
                (1.15 * wide, rise + 0.35),
                (0.7 * wide, rise + 1.1),
            ],
            n,
        )
        parts += shifted([frustum(wide, 0.97 * wide, rise, n), roof], z=z)
        z += rise + 0.7
        wide, rise = shrink * wide, shrink * rise
    spire = lathe([(0.3 * wide, 0.0), (0.12 * wide, 0.6), (0.25 * wide, 1.0), (0.1 * wide, 1.6), (0.02 * wide, 3.5)], 10).at(
        z=z - 0.1
    )
    return [part.turned(pi / n) for part in [*parts, spire]]

"""Plants in pots, and trees."""

from math import cos, pi, sin

import numpy as np

from viewgain.shapes._assemble import Parts, around, shifted
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import hollow, lathe
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import smooth
from viewgain.shapes._primitives import ellipsoid
from viewgain.shapes._sweep import sweep

_LEAF = unit_circle(6) * (1.0, 0.04)


def plant(dice: Dice) -> Parts:
    """Return a plant in a pot of 0.05 to 0.16 m radius, uniform; 0.1 to 1.4 m high.

    Kinds: rosette of arching leaves in 1 to 3 tiers (22 %), small tree of 3 to 8 crowns (20 %), 5 to 14 blades (18 %), cactus
    with 0 to 4 arms or of 2 to 4 balls (15 %), 3 to 7 flowers (13 %), palm (12 %). Pot: round (70 %) or of 4 to 8 sides, with a
    collar (50 %), a saucer (30 %).
    """
    size = dice.between(0.05, 0.16)
    deep = size * dice.between(1.2, 1.9)
    kind = dice.pick(rosette=0.22, blades=0.18, cactus=0.15, tree=0.2, palm=0.12, flowers=0.13)
    build = {"rosette": _rosette, "blades": _blades, "cactus": _cactus, "tree": _tree, "palm": _palm, "flowers": _flowers}[kind]
    return [*_pot(dice, size, deep), *shifted(build(dice, size), z=0.85 * deep)]


def _pot(dice: Dice, size: float, deep: float) -> Parts:
    """Return a pot filled with soil."""
    foot, sides = size * dice.between(0.6, 0.95), dice.count(4, 8) if dice.chance(0.3) else dice.count(9, 14) * 2
    collar = dice.chance(0.5)
    outer = (
        [(foot, 0.0), (0.95 * size, 0.8 * deep), (1.08 * size, 0.8 * deep + 1e-3), (1.08 * size, deep)]
        if collar
        else [(foot, 0.0), ((foot + size) / 2, 0.4 * deep), (size, deep)]
    )
    parts = [lathe(hollow(outer, 0.1 * size, 0.86 * deep), sides)]
    return [*parts, lathe([(1.1 * foot, -0.02), (1.35 * foot, 0.01), (0.9 * foot, 0.012)], 24)] if dice.chance(0.3) else parts


def _leaf(long: float, wide: float, droop: float, lift: float, *, start: float = 0.0, bends: int = 8) -> Part:
    """Return a leaf that leaves the z axis towards +x, climbs at the angle ``lift`` and bends down by ``droop`` at its tip."""
    t = np.linspace(0.0, 1.0, bends + 1)
    angle = lift - droop * t
    path = np.column_stack([np.cos(angle), np.zeros(bends + 1), np.sin(angle)]).cumsum(axis=0) * (long / bends)
    path[:, 0] += start
    scale = np.ones((bends + 1, 2))
    scale[:, 0] = np.sin(pi * (0.08 + 0.9 * t)) ** 0.8
    return sweep(path, _LEAF * (wide / 2), scale=scale, up=(-sin(lift), 0.0, cos(lift)))


def _rosette(dice: Dice, size: float) -> Parts:
    """Return arching leaves around a centre, in 1 to 3 tiers."""
    tiers, long = dice.count(1, 3), size * dice.between(2.2, 4.0)
    parts: Parts = []
    for tier in range(tiers):
        leaf = _leaf(long * (1 - 0.15 * tier), long * dice.between(0.12, 0.3), dice.between(0.8, 2.2), 0.6 + 0.35 * tier)
        parts += around(leaf, dice.count(5, 9), dice.between(0.0, 1.0))
    return parts


def _blades(dice: Dice, size: float) -> Parts:
    """Return nearly upright blades from spots in the pot."""
    parts = []
    for k in range(dice.count(5, 14)):
        reach = size * dice.between(0.05, 0.6)
        long, wide = size * dice.between(3.0, 7.0), size * dice.between(0.35, 0.6)
        blade = _leaf(long, wide, dice.between(-0.1, 0.35), dice.between(1.25, 1.5), start=reach)
        parts.append(blade.turned(2.4 * k))
    return parts


def _cactus(dice: Dice, size: float) -> Parts:
    """Return a ribbed column with bent arms, or a pile of balls."""
    tall, r, ribs = size * dice.between(2.5, 5.5), size * dice.between(0.35, 0.6), dice.count(6, 12)
    if dice.chance(0.3):
        balls = dice.count(2, 4)
        return [
            _ribbed(ellipsoid(2.2 * r * 0.85**k, 2.2 * r * 0.85**k, 2.0 * r * 0.85**k, 8, 2 * ribs)).at(z=(0.7 + 1.45 * k) * r)
            for k in range(balls)
        ]
    profile = [(r, 0.0), (r, 0.85 * tall), (0.88 * r, 0.94 * tall), (0.5 * r, 0.99 * tall), (0.0, tall)]
    parts = [_ribbed(lathe(profile, 2 * ribs))]
    for k in range(dice.count(0, 4)):
        z, up, out = tall * dice.between(0.3, 0.65), tall * dice.between(0.2, 0.4), r * dice.between(1.9, 2.5)
        path = smooth([(0, 0, z), (0.8 * out, 0, z), (out, 0, z + 0.3 * up), (out, 0, z + up)], 10)
        parts.append(
            sweep(path, unit_circle(10) * 0.5 * r, scale=[1, 1, 1, 1, 1, 1, 1, 1, 0.95, 0.6]).turned(
                2.0 * k + dice.between(0.0, 1.0)
            )
        )
    return parts


def _ribbed(part: Part) -> Part:
    """Return the part with every other vertex around the axis pulled in: twice as many sides as ribs must be given."""
    radius = np.hypot(part.vertices[:, 0], part.vertices[:, 1])
    inner = np.ones(len(radius))
    inner[1:-2:2] = 0.82
    return Part(part.vertices * np.column_stack([inner, inner, np.ones_like(inner)]), part.faces)


def _tree(dice: Dice, size: float) -> Parts:
    """Return a bent trunk with branches that end in crowns: balls, cones or discs."""
    tall, count = size * dice.between(3.5, 7.0), dice.count(3, 8)
    lean = size * dice.between(-0.8, 0.8)
    trunk = smooth([(0, 0, 0), (lean, 0.3 * lean, 0.5 * tall), (0.5 * lean, 0, tall)], 9)
    r = 0.12 * size
    parts = [sweep(trunk, unit_circle(8) * r, scale=np.linspace(1.3, 0.6, 9))]
    style, wide = dice.pick(ball=0.45, cone=0.3, disc=0.25), size * dice.between(1.2, 2.2)
    if style == "cone":
        layers = [
            lathe(
                [(wide * (1 - 0.8 * k / count), 0.0), (0.12 * wide * (1 - 0.8 * k / count), 0.45 * tall / count + 0.4 * size)], 14
            )
            for k in range(count)
        ]
        return parts + [layer.at(0.6 * lean, 0.0, tall * (0.3 + 0.7 * k / count)) for k, layer in enumerate(layers)]
    for k in range(count):
        angle, share = 2.4 * k, 0.5 + 0.5 * (k + 1) / count
        out = size * dice.between(0.5, 1.5) * (1.2 - 0.9 * (k + 1) / count)
        x, y, z = trunk[min(8, int(share * 8))]
        end = (x + out * cos(angle), y + out * sin(angle), z + 0.4 * size)
        parts.append(
            sweep([(x, y, z - 0.3 * size), ((x + end[0]) / 2, (y + end[1]) / 2, z + 0.1 * size), end], unit_circle(6) * 0.5 * r)
        )
        crown = wide * dice.between(0.7, 1.1)
        parts.append(ellipsoid(crown, crown, crown * (0.85 if style == "ball" else 0.35), 6, 12).at(*end))
    return parts


def _palm(dice: Dice, size: float) -> Parts:
    """Return a ringed stem with a head of hanging leaves."""
    tall, rings, r = size * dice.between(3.0, 6.0), dice.count(4, 9), size * dice.between(0.12, 0.22)
    profile = [(r * (1.15 if k % 2 else 0.9), tall * k / (2 * rings)) for k in range(2 * rings + 1)]
    long = size * dice.between(2.5, 4.0)
    leaves = around(_leaf(long, 0.16 * long, dice.between(1.4, 2.4), 0.7), dice.count(6, 11))
    inner = around(_leaf(0.8 * long, 0.14 * long, 1.0, 1.2), dice.count(3, 6), 0.4)
    return [lathe(profile, 10), *shifted([*leaves, *inner], z=tall)]


def _flowers(dice: Dice, size: float) -> Parts:
    """Return stems with leaves and heads of 5 to 8 petals."""
    parts: Parts = []
    petals, head = dice.count(5, 8), size * dice.between(0.45, 0.8)
    petal = _leaf(head, 0.6 * head, 0.8, 0.7, bends=4)
    cup = [*around(petal, petals), ellipsoid(0.4 * head, 0.4 * head, 0.25 * head, 5, 10)]
    for k in range(dice.count(3, 7)):
        tall, out = size * dice.between(3.0, 5.5), size * dice.between(0.2, 1.5)
        stem = smooth([(0.1 * size, 0, 0), (0.3 * out, 0, 0.5 * tall), (out, 0, tall)], 7)
        leaf = _leaf(0.35 * tall, 0.1 * tall, 0.9, 0.9, start=0.25 * out).at(z=tall * dice.between(0.2, 0.45))
        parts += [part.turned(2.4 * k) for part in (sweep(stem, unit_circle(6) * 0.06 * size), leaf, *shifted(cup, out, z=tall))]
    return parts

"""Wrenches: lying on the floor."""

from math import pi

import numpy as np

from viewgain.shapes._assemble import Parts
from viewgain.shapes._dice import Dice
from viewgain.shapes._extrude import extrude
from viewgain.shapes._outline import polar, rectangle, superellipse, unit_circle
from viewgain.shapes._part import Part, loop_skin
from viewgain.shapes._path import arc, rounded
from viewgain.shapes._primitives import board, cylinder, ellipsoid, tapered, torus
from viewgain.shapes._sweep import sweep


def wrench(dice: Dice) -> Parts:
    """Return a wrench: 0.12 to 0.4 m between the ends, width 0.085 to 0.12 of that; uniform.

    Fixed (68 %): each end an open jaw, a ring with a round or cornered hole, or a socket, the second may be bare, with or
    without an eye; on 60 % the ends are raised, by up to 0.9 of the thickness. Adjustable (20 %), pipe wrench with 3 to 7 teeth
    (12 %). Shaft: flat, ribbed or round.
    """
    long = dice.between(0.12, 0.4)
    wide = dice.between(0.085, 0.12) * long
    thick = dice.between(0.4, 0.6) * wide
    kind = dice.pick(fixed=0.68, adjustable=0.2, pipe=0.12)
    if kind != "fixed":
        return _adjustable(dice, long, wide, thick) if kind == "adjustable" else _pipe_wrench(dice, long, wide, thick)
    ends = [dice.pick(jaw=0.45, ring=0.35, socket=0.2), dice.pick(jaw=0.35, ring=0.3, socket=0.15, none=0.2)]
    size = wide * dice.between(0.95, 1.25)
    drop = dice.between(0.2, 0.9) * thick if dice.chance(0.6) else 0.0
    parts = _shaft(dice, long, wide, thick, drop)
    for end, (style, way) in enumerate(zip(ends, (0.0, pi), strict=True)):
        scale = 1.0 if end == 0 else dice.between(0.75, 0.95)
        parts += [part.at(long / 2).turned(way).at(z=drop / 2) for part in _wrench_end(dice, style, scale * size, thick)]
    return parts


def _shaft(dice: Dice, long: float, wide: float, thick: float, drop: float) -> Parts:
    """Return the shaft between the ends, bent down in the middle by ``drop``."""
    style = dice.pick(flat=0.4, ribbed=0.35, round=0.25)
    half = 0.48 * long
    places = (
        [(-1.0, drop), (-0.8, drop), (-0.6, 0.0), (0.6, 0.0), (0.8, drop), (1.0, drop)] if drop > 0 else [(-1.0, 0.0), (1.0, 0.0)]
    )
    path = rounded([(share * half, 0.0, z) for share, z in places], 0.05 * long, 2)
    section = (
        unit_circle(12) * (0.4 * thick, 0.4 * thick) if style == "round" else rectangle(0.62 * wide, 0.6 * thick, 0.15 * thick, 2)
    )
    parts = [sweep(path, section, up=(0.0, 0.0, 1.0))]
    if style == "ribbed":
        parts += [board(1.05 * half, 0.16 * wide, 0.8 * thick).at(y=side * 0.27 * wide, z=-0.4 * thick) for side in (1, -1)]
    return parts


def _wrench_end(dice: Dice, style: str, size: float, thick: float) -> Parts:
    """Return one end about the origin, its opening towards +x."""
    if style == "none":
        eye = [torus(0.42 * size, 0.5 * thick, 18, 8).at(0.3 * size)] if dice.chance(0.4) else []
        return [*eye, cylinder(0.4 * size, 0.7 * thick, dice.count(6, 9) * 2).at(z=-0.35 * thick)]
    if style == "jaw":
        gap, turn = dice.between(0.55, 0.75), dice.between(-0.27, 0.27)
        curve = arc(0.72 * size, gap, 2 * pi - gap, 15)
        path = np.column_stack([curve[:, 0] * 0.95, curve[:, 1], np.zeros(15)])
        heavy = np.column_stack([0.75 + 0.35 * np.abs(np.linspace(-1, 1, 15)) ** 0.7, np.ones(15)])
        return [sweep(path, rectangle(0.72 * size, thick, 0.15 * thick, 2), scale=heavy).turned(turn).at(0.4 * size)]
    if style == "ring":
        return [_ring_end(0.5 * size, 0.82 * size, 1.1 * thick, dice.count(6, 12) if dice.chance(0.5) else 24).at(0.4 * size)]
    tall = dice.between(1.5, 2.6) * thick
    return [_ring_end(0.4 * size, 0.66 * size, tall, 24).at(0.3 * size, z=0.5 * tall - 0.55 * thick)]


def _ring_end(inner: float, outer: float, thick: float, corners: int) -> Part:
    """Return a ring in the x-y plane with a many-sided hole."""
    half, cut = thick / 2, 0.12 * (outer - inner)
    turn = np.arange(24) * (2 * pi / 24)
    hole = inner * (1 + (0.08 if corners < 13 else 0.0) * np.cos(corners * turn))
    around_hole, rim = polar(hole), unit_circle(24) * outer
    stack = [
        (rim * (1 - cut / outer), -half),
        (rim, cut - half),
        (rim, half - cut),
        (rim * (1 - cut / outer), half),
        (around_hole, half),
        (around_hole, -half),
    ]
    rings = np.array([np.column_stack([outline, np.full(24, z)]) for outline, z in stack])
    return loop_skin(rings)


def _adjustable(dice: Dice, long: float, wide: float, thick: float) -> Parts:
    """Return an adjustable wrench: a fixed jaw, a sliding one and the worm that moves it; a hole or a ball at the other end."""
    size, x = 1.2 * wide, 0.46 * long
    gap = dice.between(0.25, 0.9) * size
    head = extrude(superellipse(1.9 * size, 1.6 * size, 2.5, 28), 1.2 * thick, bevel=0.2 * thick).at(x, z=-0.6 * thick)
    jaw = tapered((1.9 * size, 1.2 * thick), (1.3 * size, 0.9 * thick), 0.6 * size, (0.2 * size, 0.0)).turned(-pi / 2, "x")
    jaws = [jaw.at(x + 0.9 * size, 0.2 * size), jaw.mirrored().at(x + 0.9 * size, 0.2 * size - gap)]
    worm = [cylinder(0.22 * size, 0.6 * size, 12).turned(pi / 2, "y").at(x - 0.2 * size, -0.6 * size)]
    thread = torus(0.22 * size, 0.06 * size, 12, 6).turned(pi / 2, "y")
    worm += [thread.at(x + k * 0.12 * size - 0.1 * size, -0.6 * size) for k in range(dice.count(2, 4))]
    end = torus(0.32 * wide, 0.3 * wide, 20, 8) if dice.chance(0.5) else ellipsoid(0.9 * wide, 0.9 * wide, 0.8 * thick)
    return [*_shaft(dice, long, wide, thick, 0.0), head, *jaws, *worm, end.at(-0.5 * long)]


def _pipe_wrench(dice: Dice, long: float, wide: float, thick: float) -> Parts:
    """Return a pipe wrench: a straight bar, a heel jaw and a hook jaw with teeth."""
    size, gap = 1.3 * wide, dice.between(0.3, 0.9) * wide
    bar = tapered((1.3 * thick, 0.5 * wide), (1.5 * thick, 0.9 * wide), long).turned(pi / 2, "y").at(-long / 2)
    x = 0.46 * long
    heel = board(0.8 * size, 1.6 * size, 1.5 * thick).at(x, 0.3 * size, -0.75 * thick)
    hook = rounded([(0.2 * long, -0.2 * wide, 0), (x + size + gap, -0.2 * wide, 0), (x + size + gap, 1.25 * size, 0)], 0.4 * size)
    teeth = dice.count(3, 7)
    tooth = tapered((0.9 * size / teeth, thick), (0.1 * size / teeth, thick), 0.12 * size).turned(pi / 2, "y").turned(pi / 2, "x")
    parts = [
        bar,
        heel,
        sweep(hook, rectangle(0.7 * size, 1.3 * thick, 0.1 * thick, 1)),
        torus(0.3 * size, 0.16 * size, 18, 8).turned(pi / 2, "y").at(x - 0.8 * size),
    ]
    return parts + [tooth.at(x + 0.39 * size, 0.3 * size + (k / teeth - 0.4) * 1.5 * size) for k in range(teeth)]

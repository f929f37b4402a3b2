"""Airplanes: nose towards +x."""

from math import pi

import numpy as np

from viewgain.shapes._assemble import Parts, both_sides
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import lathe
from viewgain.shapes._part import Part
from viewgain.shapes._path import smooth
from viewgain.shapes._primitives import ellipsoid, frustum
from viewgain.shapes._sweep import rod
from viewgain.shapes._wheels import wheel
from viewgain.shapes._wing import wing


def airplane(dice: Dice) -> Parts:
    """Return an airplane: 6 to 11 m long (light), 12 to 18 m (fighter) or 18 to 40 m (airliner), span 0.5 to 2 lengths; uniform.

    Kinds: airliner (40 %; 2 or 4 engines under the wing, 2 or 3 at the tail), light (25 %; high or low wing, 1 or 2 propellers),
    fighter (15 %; swept or delta wing), biplane (10 %), glider (10 %). Tail: conventional (50 %), T (20 %), twin (18 %), V (12
    %). Gear or floats.
    """
    kind = dice.pick(airliner=0.4, light=0.25, fighter=0.15, biplane=0.1, glider=0.1)
    light = kind in ("light", "biplane", "glider")
    length = dice.between(6.0, 11.0) if light else dice.between(12.0, 18.0) if kind == "fighter" else dice.between(18.0, 40.0)
    width = length * {"airliner": dice.between(0.09, 0.13), "glider": 0.08}.get(kind, dice.between(0.1, 0.15))
    parts = [_fuselage(dice, kind, length, width)]
    parts += _tail(dice, kind, length, width)
    build = {"airliner": _airliner, "fighter": _fighter, "glider": _glider}.get(kind, _propeller_plane)
    parts += build(dice, kind, length, width)
    if kind != "airliner":
        canopy = ellipsoid(dice.between(0.16, 0.26) * length, 0.7 * width, 0.9 * width)
        parts.append(canopy.at((0.22 if kind == "fighter" else 0.1) * length, z=0.33 * width))
    elif dice.chance(0.15):
        parts.append(ellipsoid(0.4 * length, 0.75 * width, 0.6 * width).at(0.22 * length, z=0.36 * width))
    return parts


def _fuselage(dice: Dice, kind: str, length: float, width: float) -> Part:
    """Return the hull: a turned body along x whose tail bends up."""
    blunt = dice.between(0.5, 0.8) if kind != "fighter" else dice.between(0.2, 0.35)
    tail = dice.between(0.12, 0.3) if kind != "fighter" else 0.55
    belly = dice.between(0.35, 0.6)
    knots = [
        (tail, -0.5),
        (0.3 + 0.7 * tail, -0.36),
        (0.97, belly - 0.65),
        (1.0, 0.0),
        (1.0, belly - 0.3),
        (0.2 + 0.75 * blunt, 0.44),
        (0.35 * blunt, 0.495),
    ]
    profile = smooth([(r * width / 2, x * length) for r, x in knots], 26)
    profile[:, 0] = np.maximum(profile[:, 0], 0.03 * width)
    body = lathe(profile, dice.count(8, 11) * 2).turned(pi / 2, "y")
    x = body.vertices[:, 0]
    lift = np.clip(-x / length - 0.15, 0.0, None) ** 2 * 2.2 * width * dice.between(0.0, 2.0)
    return Part(np.column_stack([x, body.vertices[:, 1], body.vertices[:, 2] + lift]), body.faces)


def _tail(dice: Dice, kind: str, length: float, width: float) -> Parts:
    """Return fins and tailplanes."""
    style = dice.pick(conventional=0.5, t=0.2, v=0.12, twin=0.18)
    x, chord, tall = -0.44 * length, dice.between(0.1, 0.15) * length, dice.between(0.12, 0.19) * length
    span = dice.between(0.14, 0.2) * length
    back = dice.between(0.2, 0.7) * chord
    fin = wing(chord, dice.between(0.45, 0.7) * chord, tall, sweep=back).turned(pi / 2, "x")
    plane = wing(0.8 * chord, dice.between(0.35, 0.6) * chord, span, sweep=0.6 * back)
    if style == "v":
        return both_sides([wing(chord, 0.5 * chord, 1.1 * tall, sweep=back).turned(dice.between(0.6, 0.9), "x").at(x)])
    if style == "twin":
        reach = span if kind != "fighter" else 0.45 * width
        return both_sides(
            [
                plane.at(x),
                fin.at(x - (0.6 * back if kind != "fighter" else 0.0), reach, -0.2 * tall if kind != "fighter" else 0.0),
            ]
        )
    if style == "t":
        return [fin.at(x), *both_sides([plane.at(x - 0.95 * back, z=0.97 * tall)])]
    return [fin.at(x), *both_sides([plane.at(x, 0.0, 0.1 * width)])]


def _airliner(dice: Dice, kind: str, length: float, width: float) -> Parts:
    """Return swept wings with jets."""
    span, root = dice.between(0.42, 0.56) * length, dice.between(0.16, 0.22) * length
    sweep, rise, x = dice.between(0.3, 0.6) * span, dice.between(0.02, 0.12) * span, dice.between(0.0, 0.08) * length
    high = dice.chance(0.2)
    z = 0.4 * width if high else -0.3 * width
    if high:
        rise = -0.4 * rise
    tip = dice.between(0.22, 0.4) * root
    parts = both_sides([wing(root, tip, span, sweep=sweep, rise=rise).at(x, z=z)])
    if dice.chance(0.4):
        fin = wing(0.9 * tip, 0.4 * tip, 0.09 * span, sweep=0.4 * tip).turned(1.3, "x")
        parts += both_sides([fin.at(x - sweep, 0.995 * span, z + rise)])
    jet = _jet(dice.between(0.1, 0.14) * length, dice.between(0.36, 0.5) * width)
    style = dice.pick(two=0.5, four=0.2, tail=0.2, three=0.1)
    if style in ("two", "four"):
        for share in (0.3,) if style == "two" else (0.28, 0.55):
            parts += both_sides(
                [jet.at(x - share * sweep + 0.5 * root * (1 - share), share * span, z + share * rise - 0.3 * width)]
            )
    else:
        parts += both_sides([jet.at(-0.3 * length, 0.68 * width, 0.2 * width)])
        parts += [jet.at(-0.4 * length, z=0.62 * width)] if style == "three" else []
    return parts + _gear(dice, 0.3 * length, x - 0.05 * length, 0.9 * width, 0.08 * width, chance=0.5)


def _jet(length: float, width: float) -> Part:
    """Return an engine along x: open in front, with a cone behind."""
    r = width / 2
    profile = [
        (0.35 * r, -0.5),
        (0.5 * r, -0.3),
        (0.9 * r, -0.2),
        (r, 0.15),
        (0.95 * r, 0.5),
        (0.8 * r, 0.48),
        (0.75 * r, 0.2),
        (0.0, 0.3),
    ]
    return lathe([(radius, x * length) for radius, x in profile], 16).turned(pi / 2, "y")


def _fighter(dice: Dice, kind: str, length: float, width: float) -> Parts:
    """Return a delta or swept wing, intakes, and stores under the wing."""
    delta = dice.chance(0.5)
    span = dice.between(0.26, 0.34) * length
    root, tip = (0.5 * length, 0.06 * length) if delta else (0.26 * length, dice.between(0.08, 0.14) * length)
    sweep, x = (0.21 * length, -0.12 * length) if delta else (dice.between(0.1, 0.2) * length, -0.02 * length)
    parts = both_sides([wing(root, tip, span, sweep=sweep, thickness=0.05).at(x)])
    if delta and dice.chance(0.5):
        parts += both_sides(
            [
                wing(0.1 * length, 0.05 * length, 0.14 * length, sweep=0.06 * length, thickness=0.06).at(
                    0.22 * length, z=0.15 * width
                )
            ]
        )
    intake = _jet(0.34 * length, 0.6 * width)
    parts += (
        both_sides([intake.at(0.02 * length, 0.5 * width, -0.15 * width)])
        if dice.chance(0.7)
        else [intake.at(0.05 * length, z=-0.45 * width)]
    )
    for k in range(dice.count(0, 3)):
        y = (0.35 + 0.2 * k) * span
        parts += both_sides(
            [
                rod(
                    (x - 0.6 * sweep - 0.08 * length, y, -0.25 * width),
                    (x - 0.6 * sweep + 0.1 * length, y, -0.25 * width),
                    0.09 * width,
                    0.05 * width,
                )
            ]
        )
    return parts + _gear(dice, 0.28 * length, -0.1 * length, 0.8 * width, 0.1 * width, chance=0.5)


def _propeller_plane(dice: Dice, kind: str, length: float, width: float) -> Parts:
    """Return straight wings (two pairs on a biplane), a propeller, struts, and wheels or floats."""
    span, chord, x = dice.between(0.48, 0.68) * length, dice.between(0.15, 0.21) * length, 0.12 * length
    tip, rise = dice.between(0.6, 1.0) * chord, dice.between(0.0, 0.08) * span
    high = kind == "biplane" or dice.chance(0.5)
    low = kind == "biplane" or not high
    top = dice.between(0.8, 1.1) * width if kind == "biplane" else 0.55 * width
    parts: Parts = []
    if high:
        parts += both_sides([wing(chord, tip, span, rise=rise).at(x, z=top)])
    if low:
        parts += both_sides([wing(chord, tip, span * (0.9 if high else 1.0), rise=rise).at(x, z=-0.35 * width)])
    if high:
        r = 0.05 * width
        places = (0.5, 0.8) if kind == "biplane" else (0.5,)
        foot = (lambda y: y) if kind == "biplane" else (lambda y: 0.4 * width)
        parts += both_sides(
            [
                rod((x + dx, foot(p * span), -0.33 * width), (x + dx, p * span, top + p * rise), r, sides=6)
                for p in places
                for dx in (-0.2 * chord, 0.2 * chord)
            ]
        )
    if kind == "biplane":
        parts += both_sides([rod((x, 0.2 * width, 0.2 * width), (x, 0.4 * width, top), 0.05 * width, sides=6)])
    engines = (
        [(0.5 * length, 0.0, 0.0)]
        if kind == "biplane" or dice.chance(0.7)
        else [(x + 0.75 * chord, s * 0.35 * span, top if high else -0.3 * width) for s in (1, -1)]
    )
    blades, reach = dice.count(2, 4), dice.between(0.75, 1.0) * width
    for ex, ey, ez in engines:
        parts += [
            part.at(ex, ey, ez) for part in _propeller(blades, reach, width, nacelle=0.9 * chord if len(engines) > 1 else 0.0)
        ]
    if dice.chance(0.2):
        hull = ellipsoid(0.6 * length, 0.3 * width, 0.35 * width, 8, 14).at(x, 0.75 * width, -1.15 * width)
        bars = [
            rod((x + dx, 0.3 * width, -0.3 * width), (x + dx, 0.75 * width, -1.1 * width), 0.05 * width)
            for dx in (-0.1 * length, 0.12 * length)
        ]
        return parts + both_sides([hull, *bars])
    return parts + _gear(dice, 0.36 * length, x - 0.02 * length, 0.75 * width, 0.24 * width, chance=0.8)


def _propeller(blades: int, reach: float, width: float, nacelle: float) -> Parts:
    """Return a spinner and blades that face +x, and the engine's body behind them if it hangs on a wing."""
    blade = wing(0.2 * reach, 0.1 * reach, reach, thickness=0.25).turned(0.9, "y").turned(pi / 4, "x")
    parts = [frustum(0.13 * width, 0.03 * width, 0.3 * width, 12).turned(pi / 2, "y").at(-0.05 * width)]
    parts += [blade.turned(2 * pi * k / blades, "x") for k in range(blades)]
    return [*parts, ellipsoid(2 * nacelle, 0.42 * width, 0.42 * width).at(-0.8 * nacelle)] if nacelle else parts


def _glider(dice: Dice, kind: str, length: float, width: float) -> Parts:
    """Return long slender wings."""
    span, chord = dice.between(0.75, 1.0) * length, dice.between(0.09, 0.13) * length
    rise = dice.between(0.02, 0.1) * span
    parts = both_sides(
        [
            wing(chord, dice.between(0.3, 0.6) * chord, span, sweep=0.15 * chord, rise=rise).at(
                0.08 * length, z=dice.between(-0.1, 0.4) * width
            )
        ]
    )
    return [*parts, wheel(0.25 * width, 0.12 * width).at(0.1 * length, z=-0.45 * width)]


def _gear(dice: Dice, front: float, rear: float, reach: float, radius: float, *, chance: float) -> Parts:
    """Return three wheels on struts, with a share of the time."""
    if not dice.chance(chance):
        return []
    tyre = wheel(radius, 0.6 * radius, 12)
    drop = -reach
    y = 0.75 * reach
    parts = both_sides([rod((rear, 0.3 * y, 0.0), (rear, y, drop), 0.25 * radius), tyre.at(rear, y, drop)])
    return [*parts, rod((front, 0.0, 0.0), (front, 0.0, drop), 0.25 * radius), tyre.at(front, z=drop)]

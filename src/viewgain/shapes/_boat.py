"""Boats: bow towards +x, keel on z = 0."""

from itertools import pairwise
from math import pi

import numpy as np

from viewgain.arrays import Vector
from viewgain.shapes._assemble import Parts, both_sides, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._part import Part, skin
from viewgain.shapes._primitives import board, cylinder, ellipsoid, frustum, tapered
from viewgain.shapes._sweep import rod
from viewgain.shapes._wing import wing


def boat(dice: Dice) -> Parts:
    """Return a boat: 2.5 to 60 m long; uniform within each kind.

    Kinds: rowing boat 2.5 to 5 m (20 %; 1 to 4 thwarts, 0 to 2 pairs of oars), motor boat 5 to 12 m (30 %; a cabin or a cockpit,
    0 to 3 outboards, a rail), sailing boat 5 to 12 m (25 %; 1 or 2 masts, up to 3 sails, a keel), ship 20 to 60 m (25 %; a bridge
    of 2 to 5 decks, 0 to 3 funnels, containers, hatches or cranes).
    """
    kind = dice.pick(rowing=0.2, motor=0.3, sail=0.25, ship=0.25)
    build = {"rowing": _rowing, "motor": _motor, "sail": _sail, "ship": _ship}[kind]
    return build(dice)


def _hull(dice: Dice, length: float, beam: float, depth: float, *, hollow: float, stern: float) -> Part:
    """Return the hull: sections across x, wide amidships, rising to a sharp bow; ``hollow`` is how deep it is dug out, 0 to 1.

    Each section runs from the starboard rim down, under the keel, up to the port rim and back across the deck or through the
    inside.
    """
    u = np.concatenate([np.linspace(0.0, 0.8, 10), [0.87, 0.93, 0.97, 1.0]])
    full = dice.between(1.6, 3.0)
    breadth = beam / 2 * np.minimum(stern + (1 - stern) * np.sin(np.clip(u / 0.45, 0, 1) * pi / 2), (1 - u**full * 0.985) ** 0.7)
    sheer = depth * (1 + dice.between(0.1, 0.45) * u**2.5 + dice.between(0.0, 0.15) * (1 - u) ** 3)
    keel = depth * dice.between(0.3, 0.8) * np.clip((u - 0.7) / 0.3, 0, 1) ** 2
    vee = dice.between(0.35, 0.75)
    outer = [(-1.0, 1.0), (-0.95, 0.6), (-vee, 0.2), (0.0, 0.0), (vee, 0.2), (0.95, 0.6), (1.0, 1.0)]
    dug = np.clip(hollow * np.minimum(1, 8 * u) * np.minimum(1, 4 * (1 - u)), 0.02, None)
    rings = np.empty((len(u), 14, 3))
    rings[:, :, 0] = (u * length - length / 2)[:, None]
    for k, (side, share) in enumerate(outer):
        rings[:, k, 1] = side * breadth
        rings[:, k, 2] = keel + share * (sheer - keel)
    inner = [(0.92, 0.0), (0.82, 0.5), (0.45, 0.92), (0.0, 1.0), (-0.45, 0.92), (-0.82, 0.5), (-0.92, 0.0)]
    for k, (side, share) in enumerate(inner):
        rings[:, 7 + k, 1] = side * breadth
        rings[:, 7 + k, 2] = sheer - share * dug * 0.85 * (sheer - keel)
    tip = [np.array([x, 0.0, z]) for x, z in _end_tips(u, length, keel, sheer)]
    return skin(rings, tip[0], tip[1])


def _end_tips(u: Vector, length: float, keel: Vector, sheer: Vector) -> list[tuple[float, float]]:
    """Return (x, z) where the fans of transom and bow meet."""
    return [(float(u[k] * length - length / 2), float((keel[k] + sheer[k]) / 2)) for k in (0, -1)]


def _rowing(dice: Dice) -> Parts:
    """Return an open boat with thwarts and oars."""
    length, beam, depth = dice.between(2.5, 5.0), dice.between(1.0, 1.6), dice.between(0.4, 0.6)
    parts = [_hull(dice, length, beam, depth, hollow=0.9, stern=dice.between(0.2, 0.8))]
    places = [-0.3, -0.08, 0.12, 0.28][: dice.count(1, 4)]
    parts += [board(0.24, 0.82 * beam, 0.03).at(x * length, z=0.72 * depth) for x in places]
    for x in places[: dice.count(0, 2)]:
        reach = dice.between(0.8, 1.2) * beam
        oar = rod((x * length, 0.2 * beam, 1.25 * depth), (x * length + 0.1, 0.35 * beam + reach, 0.4 * depth), 0.025)
        parts += both_sides(
            [oar, ellipsoid(0.05, 0.6, 0.16).turned(-0.3, "x").at(x * length + 0.1, 0.35 * beam + reach, 0.4 * depth)]
        )
    return parts + (_outboards(dice, length, depth, 1) if dice.chance(0.25) else [])


def _outboards(dice: Dice, length: float, depth: float, count: int) -> Parts:
    """Return motors that hang on the transom."""
    parts: Parts = []
    for y in spread(count, 0.45 * depth * (count - 1)):
        x = -length / 2 - 0.18 * depth
        parts += [ellipsoid(0.55 * depth, 0.35 * depth, 0.5 * depth).at(x, y, 1.15 * depth)]
        parts += [
            board(0.2 * depth, 0.1 * depth, 1.1 * depth).at(x, y),
            ellipsoid(0.4 * depth, 0.2 * depth, 0.2 * depth, 5, 10).at(x, y),
        ]
    return parts


def _motor(dice: Dice) -> Parts:
    """Return a motor boat with a cabin or an open cockpit."""
    length = dice.between(5.0, 12.0)
    beam, depth = length * dice.between(0.26, 0.36), length * dice.between(0.1, 0.15)
    cabin = dice.pick(none=0.25, low=0.35, wheelhouse=0.25, flybridge=0.15)
    parts = [
        _hull(
            dice, length, beam, depth, hollow=0.6 if cabin == "none" else dice.between(0.05, 0.3), stern=dice.between(0.75, 0.95)
        )
    ]
    x = dice.between(-0.05, 0.1) * length
    if cabin == "none":
        parts += [
            board(0.05, 0.7 * beam, 0.5).turned(-0.5, "y").at(x + 0.05 * length, z=depth),
            board(0.5, 0.7 * beam, 0.45).at(x - 0.15 * length, z=0.6 * depth),
        ]
    else:
        tall = {"low": 0.08, "wheelhouse": 0.17, "flybridge": 0.14}[cabin] * length
        long = {"low": 0.45, "wheelhouse": 0.2, "flybridge": 0.45}[cabin] * length
        parts.append(tapered((long, 0.66 * beam), (0.75 * long, 0.56 * beam), tall, (-0.06 * long, 0.0)).at(x, z=0.9 * depth))
        if cabin == "flybridge":
            parts += [
                tapered((0.4 * long, 0.5 * beam), (0.3 * long, 0.46 * beam), 0.07 * length).at(
                    x - 0.1 * long, z=0.9 * depth + tall
                )
            ]
        if dice.chance(0.6):
            parts.append(rod((x - 0.2 * long, 0.0, depth + 0.9 * tall), (x - 0.3 * long, 0.0, depth + 1.8 * tall), 0.012 * beam))
    if dice.chance(0.5):
        parts += _rail(dice, length, beam, depth)
    return parts + (_outboards(dice, length, depth, dice.count(1, 3)) if dice.chance(0.5) else [])


def _rail(dice: Dice, length: float, beam: float, depth: float) -> Parts:
    """Return posts and a bar along each side of the foredeck."""
    r, tall, low = 0.004 * length, 0.06 * length, 0.95 * depth
    posts = [(0.05 * length + 0.1 * length * k, 0.4 * beam * (1 - 0.06 * k * k)) for k in range(dice.count(3, 4))]
    bars = [rod((*a, low + tall), (*b, low + tall), r, sides=6) for a, b in pairwise(posts)]
    return both_sides([*bars, *(rod((x, y, low), (x, y, low + tall), r, sides=6) for x, y in posts)])


def _sail(dice: Dice) -> Parts:
    """Return a sailing boat."""
    length = dice.between(5.0, 12.0)
    beam, depth, draught = length * dice.between(0.26, 0.34), length * dice.between(0.1, 0.14), length * dice.between(0.06, 0.14)
    parts = [_hull(dice, length, beam, depth, hollow=dice.between(0.1, 0.4), stern=dice.between(0.4, 0.85)).at(z=draught)]
    deck = draught + depth
    parts.append(
        wing(0.3 * length, 0.2 * length, draught + 0.3 * depth, sweep=0.05 * length)
        .turned(-pi / 2, "x")
        .at(0.02 * length, z=draught + 0.3 * depth)
    )
    if dice.chance(0.7):
        parts.append(tapered((0.35 * length, 0.5 * beam), (0.26 * length, 0.4 * beam), 0.06 * length).at(z=deck - 0.02 * length))
    masts = [0.1] if dice.chance(0.7) else [0.2, -0.18]
    for k, place in enumerate(masts):
        tall, x = length * dice.between(0.95, 1.25) * (1 - 0.15 * k), place * length
        boom = dice.between(0.3, 0.42) * length * (1 if len(masts) == 1 else 0.75)
        low = deck + 0.12 * length
        parts += [
            rod((x, 0.0, 0.5 * deck), (x, 0.0, deck + tall), 0.009 * length, 0.005 * length),
            rod((x, 0.0, low), (x - boom, 0.0, low), 0.006 * length),
        ]
        if dice.chance(0.85):
            parts.append(
                _sailcloth(
                    (x - 0.01 * length, low),
                    (x - boom, low),
                    (x - 0.01 * length, deck + 0.97 * tall),
                    dice.between(0.02, 0.08) * length,
                )
            )
    if dice.chance(0.7):
        parts.append(
            _sailcloth(
                (0.47 * length, deck + 0.1 * length),
                (masts[0] * length + 0.05 * length, deck + 0.1 * length),
                (masts[0] * length + 0.02 * length, deck + 0.8 * tall),
                0.05 * length,
            )
        )
    return parts


def _sailcloth(tack: tuple[float, float], clew: tuple[float, float], head: tuple[float, float], belly: float) -> Part:
    """Return a thin triangular sail between three corners given in (x, z), curved towards +y."""
    low, foot, top = np.array(tack), np.array(clew), np.array(head)
    rise, across = np.linspace(0.0, 0.95, 10), np.linspace(0.0, 1.0, 9)
    luff, leech = low + rise[:, None] * (top - low), foot + rise[:, None] * (top - foot)
    cloth = luff[:, None] + across[:, None] * (leech - luff)[:, None]
    bulge = belly * np.sin(pi * across) * np.sin(pi * rise / 0.95)[:, None]
    thick = 0.1 * belly  # more than the two diagonals of any patch lie apart, so the sides do not cross
    sides = [np.stack([cloth[..., 0], bulge + s * thick, cloth[..., 1]], axis=-1) for s in (0.5, -0.5)]
    rings = np.concatenate([sides[0], sides[1][:, ::-1]], axis=1)
    return skin(rings if low[0] > foot[0] else rings[:, ::-1], rings[0].mean(axis=0), rings[-1].mean(axis=0))


def _ship(dice: Dice) -> Parts:
    """Return a ship with a bridge, and cargo or cabins."""
    length = dice.between(20.0, 60.0)
    beam, depth = length * dice.between(0.14, 0.2), length * dice.between(0.08, 0.12)
    parts = [_hull(dice, length, beam, depth, hollow=0.02, stern=dice.between(0.7, 0.95))]
    decks, place = dice.count(2, 5), dice.pick(aft=0.5, middle=0.3, fore=0.2)
    x = {"aft": -0.32, "middle": 0.0, "fore": 0.22}[place] * length
    long, wide, tall = dice.between(0.14, 0.22) * length * (2.0 if place == "middle" else 1.0), 0.8 * beam, 0.045 * length
    for deck in range(decks):
        share = 1 - dice.between(0.06, 0.14) * deck
        parts.append(board(share * long, share * wide, tall + 0.01 * length).at(x, z=depth - 0.01 * length + deck * tall))
    top = depth + decks * tall
    parts.append(board(0.05 * length, 0.9 * beam, 0.6 * tall).at(x + 0.3 * long, z=top - 0.7 * tall))
    for k in range(dice.count(0, 3)):
        parts.append(frustum(0.16 * wide, 0.12 * wide, 1.8 * tall, 14).at(x - 0.3 * long + 0.22 * long * k, z=top - 0.1 * tall))
    parts.append(rod((x + 0.2 * long, 0.0, top), (x + 0.2 * long, 0.0, top + 2 * tall), 0.012 * beam))
    if place != "middle":
        span = (x + long, 0.3 * length) if place == "aft" else (-0.4 * length, x - long)
        parts += _cargo(dice, length, beam, depth, span)
    return parts


def _cargo(dice: Dice, length: float, beam: float, depth: float, span: tuple[float, float]) -> Parts:
    """Return containers, hatches or cranes along the deck, between two places on x."""
    start, end = span
    style, parts = dice.pick(containers=0.5, hatches=0.25, cranes=0.25), []
    count = dice.count(2, 5)
    pitch = (end - start) / count
    for k in range(count):
        x = start + (k + 0.5) * pitch
        if style == "containers":
            for y in spread(3, 0.52 * beam):
                parts += [
                    board(0.9 * pitch, 0.24 * beam, 0.04 * length * dice.count(1, 3), 0.002 * length).at(
                        x, y, depth - 0.01 * length
                    )
                ]
        else:
            parts.append(board(0.7 * pitch, 0.6 * beam, 0.025 * length).at(x, z=depth - 0.01 * length))
        if style == "cranes":
            parts += [
                cylinder(0.05 * beam, 0.12 * length, 10).at(x, z=depth),
                rod((x, 0.0, depth + 0.11 * length), (x + 0.8 * pitch, 0.0, depth + 0.16 * length), 0.025 * beam),
            ]
    return parts

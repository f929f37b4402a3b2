"""Skateboards: the way of travel is +x."""

import numpy as np

from viewgain.shapes._assemble import Parts, both_sides, shifted
from viewgain.shapes._dice import Dice
from viewgain.shapes._outline import superellipse
from viewgain.shapes._part import Part
from viewgain.shapes._primitives import board, cylinder, tapered
from viewgain.shapes._sweep import rod, sweep
from viewgain.shapes._wheels import wheel


def skateboard(dice: Dice) -> Parts:
    """Return a skateboard: deck 0.55 to 1.1 m long, 0.17 to 0.26 m wide; uniform.

    Outline: popsicle (40 %), pintail, waisted, square (20 % each); kicks at both ends, the tail or neither; camber -20 to 20 mm.
    Risers, bolts (60 %), rails (20 %); 4 wheels of 14 to 20 sides, or 6 on three trucks (30 % of the flat ones).
    """
    style = dice.pick(popsicle=0.4, pintail=0.2, waisted=0.2, square=0.2)
    length = dice.between(0.68, 0.86) if style == "popsicle" else dice.between(0.55, 1.1)
    width, thick = dice.between(0.17, 0.26), dice.between(0.012, 0.022)
    kicks = dice.pick(both=0.6 if style == "popsicle" else 0.2, tail=0.25, none=0.2)
    camber, rise = dice.between(-0.02, 0.02), dice.between(0.03, 0.07)
    radius, wide, riser = dice.between(0.024, 0.038), dice.between(0.03, 0.055), dice.between(0.0, 0.02)
    floor = 2 * radius + 0.035 + riser
    deck = _deck(
        style, length, width, thick, kicks=(rise if kicks == "both" else 0.0, rise if kicks != "none" else 0.0), camber=camber
    )
    base = dice.between(0.52, 0.62) * length
    places = [base / 2, -base / 2] if abs(camber) > 0.004 or dice.chance(0.7) else [base / 2, 0.0, -base / 2]
    sides, bolts = dice.count(7, 10) * 2, dice.chance(0.6)
    parts = [deck.at(z=floor + thick / 2 - camber * (1 - (base / length) ** 2))]
    for x in places:
        parts += shifted(_truck(width, radius, wide, floor, sides, riser=riser > 0.008), x)
        if bolts:
            bolt = cylinder(0.005, thick + 0.006, 6)
            parts += both_sides([bolt.at(x + dx, 0.02, floor) for dx in (-0.03, 0.03)])
    if dice.chance(0.2):
        parts += both_sides([rod((-0.25 * base, 0.3 * width, floor - 0.004), (0.25 * base, 0.3 * width, floor - 0.004), 0.009)])
    return parts


def _deck(style: str, length: float, width: float, thick: float, *, kicks: tuple[float, float], camber: float) -> Part:
    """Return the deck: a thin section along a line that bends up at its ends, as wide as the outline says."""
    u = np.concatenate([[-0.995, -0.97, -0.92], np.linspace(-0.84, 0.84, 15), [0.92, 0.97, 0.995]])
    power = {"popsicle": 5.0, "pintail": 2.2, "waisted": 4.0, "square": 12.0}[style]
    share = (1 - np.abs(u) ** power) ** (1 / min(power, 2.5))
    if style == "waisted":
        share = share * (1 - 0.2 * np.cos(np.pi * u) ** 2)
    if style == "pintail":
        share = share * (1 + 0.18 * u)
    bend = np.where(u > 0, kicks[0], kicks[1]) * (np.maximum(np.abs(u) - 0.66, 0) / 0.34) ** 1.3
    path = np.column_stack([u * length / 2, np.zeros_like(u), bend + camber * (1 - u**2)])
    return sweep(path, superellipse(width, thick, 4.0, 12), scale=np.column_stack([share, np.ones_like(share)]))


def _truck(width: float, radius: float, wide: float, floor: float, sides: int, *, riser: bool) -> Parts:
    """Return one axle with its hanger, base plate and two wheels, under a deck whose underside is at ``floor``."""
    axle = 0.92 * width
    hanger = tapered((0.02, 0.65 * axle), (0.06, 0.05), floor - radius, (0.0, 0.0)).at(z=radius - 0.006)
    parts = [rod((0.0, -axle / 2, radius), (0.0, axle / 2, radius), 0.005), hanger, board(0.09, 0.055, 0.01).at(z=floor - 0.012)]
    parts += both_sides([wheel(radius, wide, sides).at(y=axle / 2 - wide / 2, z=radius)])
    return [*parts, board(0.1, 0.06, 0.014).at(z=floor - 0.022)] if riser else parts

"""Backrests and armrests. A back stands on z = 0 across y, its front face towards +x; an arm runs along x."""

from math import pi

import numpy as np

from viewgain.shapes._assemble import Parts, both_sides, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._outline import rectangle, unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import rounded
from viewgain.shapes._primitives import board, cushion
from viewgain.shapes._sweep import rod, sweep


def backrest(dice: Dice, width: float, height: float) -> Parts:
    """Return a back: upright slats (25 %), a ladder (20 %), a panel (20 %), a hoop with spindles (15 %) or a cushion (20 %)."""
    style = dice.pick(slats=0.25, ladder=0.2, panel=0.2, hoop=0.15, cushion=0.2)
    if style == "hoop":
        return _hoop(dice, width, height)
    if style == "panel":
        return _panel(dice, width, height)
    if style == "cushion":
        low = dice.between(0.05, 0.25) * height
        pad = cushion(0.07, width, height - low, dice.between(0.25, 0.5)).at(0.02, z=low)
        spine = [board(0.02, dice.between(0.1, 0.9) * width, height - 0.05).at(-0.012, z=-0.03)]
        return [pad, *spine]
    return _framed(dice, width, height, upright=style == "slats")


def _framed(dice: Dice, width: float, height: float, *, upright: bool) -> Parts:
    """Return two posts and a top rail, filled with 2 to 7 bars one way or the other."""
    post = dice.between(0.025, 0.045)
    rail = dice.between(0.05, 0.12)
    side = width / 2 - post / 2
    frame = [board(post, post, height).at(y=y) for y in (side, -side)]
    frame.append(board(0.8 * post, width - post, rail).at(z=height - rail))
    bow = dice.between(0.0, 0.04)
    if upright:
        low = dice.between(0.08, 0.2) * height
        frame.append(board(0.8 * post, width - post, 0.04).at(z=low))
        count = dice.count(2, 3 + int(width / 0.12))
        slat = board(0.35 * post, dice.between(0.25, 0.6) * width / (count + 1), height - low - 0.5 * rail)
        return [*frame, *(slat.at(y=y, z=low) for y in spread(count + 2, width - post)[1:-1])]
    count = dice.count(1, 4)
    levels = [height * (0.25 + 0.6 * k / count) for k in range(count)]
    return [*frame, *(bowed_rail(width - post, bow, 0.01, rail).at(z=z) for z in levels)]


def bowed_rail(width: float, bow: float, thickness: float, height: float) -> Part:
    """Return an upright strip across y whose middle lies ``bow`` behind its ends."""
    y = np.linspace(-width / 2, width / 2, 9)
    path = np.column_stack([-bow * (1 - (2 * y / width) ** 2), y, np.full(9, height / 2)])
    return sweep(path, rectangle(thickness, height, 0.3 * thickness, 2))


def _panel(dice: Dice, width: float, height: float) -> Parts:
    """Return one bowed sheet, held by two posts if it starts above the seat."""
    low = dice.between(0.0, 0.5) * height if dice.chance(0.6) else 0.0
    bow = dice.between(0.0, 0.07)
    sheet = bowed_rail(width, bow, dice.between(0.012, 0.03), height - low).at(z=low)
    posts = [rod((-0.012, y, -0.02), (-0.012, y, height - 0.1 * height), 0.011) for y in (0.3 * width, -0.3 * width)]
    return [sheet, *posts] if low > 0 else [sheet]


def _hoop(dice: Dice, width: float, height: float) -> Parts:
    """Return an arch of bent wood and 3 to 9 spindles beneath it."""
    radius, count = dice.between(0.010, 0.016), dice.count(3, 9)
    angle = np.linspace(0, pi, 17)
    arch = np.column_stack([np.zeros(17), width / 2 * np.cos(angle), height * np.sin(angle) ** 0.7])
    spindles = [
        rod((0.0, 0.75 * y, 0.0), (0.0, y, height * (1 - (2 * y / width) ** 2) ** 0.35), 0.6 * radius, sides=6)
        for y in spread(count + 2, width)[1:-1]
    ]
    return [sweep(arch, unit_circle(8) * radius), *spindles]


def armrests(dice: Dice, depth: float, width: float, rise: float) -> Parts:
    """Return two arms over a seat ``depth`` by ``width``: pads on posts (50 %), bent tubes (30 %) or solid sides (20 %)."""
    style = dice.pick(posts=0.5, tubes=0.3, solid=0.2)
    y, front = width / 2 + 0.01, dice.between(0.25, 0.45) * depth
    back = -depth / 2
    if style == "solid":
        side = board(front - back, 0.035, rise + 0.05).at((front + back) / 2, y, -0.05)
        return both_sides([side])
    if style == "tubes":
        path = rounded([(front, y, -0.02), (front, y, rise), (back - 0.02, y, rise)], 0.06)
        return both_sides([sweep(path, unit_circle(8) * 0.012)])
    pad = board(front - back + 0.03, dice.between(0.03, 0.07), 0.025).at((front + back) / 2, y, rise)
    posts = [
        rod((x, y, -0.03), (x, y, rise + 0.01), 0.014)
        for x in ((front - 0.05,) if dice.chance(0.6) else (front - 0.05, back + 0.1))
    ]
    return both_sides([pad, *posts])

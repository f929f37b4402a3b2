"""Cabinets and bookshelves: front towards +x."""

from math import pi

from viewgain.shapes import _bases as bases
from viewgain.shapes._assemble import Parts, both_sides, shifted, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._primitives import board, ellipsoid, tapered
from viewgain.shapes._sweep import rod


def cabinet(dice: Dice) -> Parts:
    """Return a cabinet: 0.35 to 0.65 m deep, 0.5 to 1.8 m wide, 0.55 to 2.1 m high; uniform.

    1 to 4 columns, each with one door (35 %), 2 to 5 drawers (30 %), two doors (20 %) or open shelves (15 %). Handles: knobs (45
    %), bars (40 %) or none. On legs (40 %), a plinth (30 %) or the floor; top flush (40 %), overhanging (40 %) or crowned.
    """
    depth, width, height = dice.between(0.35, 0.65), dice.between(0.5, 1.8), dice.between(0.55, 2.1)
    foot = dice.pick(floor=0.3, plinth=0.3, legs=0.4)
    lift = 0.0 if foot == "floor" else dice.between(0.06, 0.2)
    parts = _carcass(depth, width, height - lift, columns := dice.count(1, 4 if width > 1 else 2))
    handle = dice.pick(knob=0.45, bar=0.4, none=0.15)
    for y in spread(columns, width * (1 - 1 / columns)):
        parts += shifted(_column(dice, depth, width / columns, height - lift, handle), y=y)
    top = dice.pick(flush=0.4, overhang=0.4, crown=0.2)
    if top != "flush":
        parts.append(board(depth + 0.05, width + 0.06, 0.03).at(0.005, z=height - lift))
    if top == "crown":
        parts.append(tapered((depth, width), (depth + 0.1, width + 0.12), 0.07).at(z=height - lift + 0.02))
    parts = shifted(parts, z=lift)
    if foot == "plinth":
        parts.append(board(0.9 * depth, 0.96 * width, lift + 0.01))
    elif foot == "legs":
        parts += bases.legs(dice, 0.96 * depth, 0.97 * width, lift + 0.01, thickness=dice.between(0.03, 0.06))
    return parts


def _carcass(depth: float, width: float, height: float, columns: int) -> Parts:
    """Return the box without its front: back, sides, top, bottom and the walls between columns."""
    t = 0.022
    walls = [board(depth, t, height).at(y=y) for y in spread(columns + 1, width - t)]
    plates = [board(depth, width, t).at(z=z) for z in (0.0, height - t)]
    return [*walls, *plates, board(0.012, width - t, height - t).at(0.006 - depth / 2, z=t / 2)]


def _column(dice: Dice, depth: float, width: float, height: float, handle: str) -> Parts:
    """Return the fronts of one column."""
    style = dice.pick(door=0.35, drawers=0.3, two=0.2, open=0.15)
    if style == "open":
        return [board(0.96 * depth, width - 0.01, 0.02).at(z=height * (k + 1) / 4) for k in range(dice.count(1, 3))]
    rows = {"door": 1, "two": 2, "drawers": dice.count(2, 5)}[style]
    pitch, gap = height / rows, 0.006
    parts: Parts = []
    for row in range(rows):
        front = board(0.022, width - gap, pitch - gap).at(depth / 2, z=row * pitch + gap / 2)
        place = (0.0, (row + 0.5) * pitch) if style == "drawers" else (0.4 * width, (row + 0.5) * pitch)
        parts += [front, *_handle(handle, upright=style != "drawers", at=(depth / 2 + 0.012, *place))]
    return parts


def _handle(style: str, *, upright: bool, at: tuple[float, float, float]) -> Parts:
    """Return a knob or a bar on a front."""
    if style == "none":
        return []
    if style == "knob":
        return [
            rod((-0.01, 0.0, 0.0), (0.02, 0.0, 0.0), 0.006).at(*at),
            ellipsoid(0.02, 0.032, 0.032, 5, 10).at(at[0] + 0.024, at[1], at[2]),
        ]
    bar = rod((0.028, -0.07, 0.0), (0.028, 0.07, 0.0), 0.006)
    pegs = [rod((-0.01, y, 0.0), (0.028, y, 0.0), 0.005, sides=6) for y in (-0.05, 0.05)]
    return shifted([part.turned(pi / 2, "x") if upright else part for part in (bar, *pegs)], *at)


def bookshelf(dice: Dice) -> Parts:
    """Return a bookshelf: 0.22 to 0.38 m deep, 0.5 to 1.5 m wide, 0.8 to 2.1 m high; uniform.

    2 to 6 levels in 1 to 3 columns; closed sides (70 %) or posts; a back (60 %); books in a share of the bays that is uniform in
    0 to 0.8. 15 % are A-frames whose shelves get shallower upwards.
    """
    depth, width, height = dice.between(0.22, 0.38), dice.between(0.5, 1.5), dice.between(0.8, 2.1)
    levels, t = dice.count(2, 6), dice.between(0.016, 0.035)
    filled = dice.between(0.0, 0.8)
    pitch = (height - t) / levels
    if dice.chance(0.15):
        return _a_frame(dice, depth, width, height, levels)
    columns = dice.count(1, 3) if width > 0.8 else 1
    parts = [board(depth, width, t).at(z=k * pitch) for k in range(levels + 1)]
    if dice.chance(0.7):
        parts += both_sides([board(depth, t, height).at(y=(width - t) / 2)])
    else:
        parts += both_sides([board(0.03, 0.03, height).at(side * (depth / 2 - 0.015), width / 2) for side in (1, -1)])
    parts += [board(0.96 * depth, t, height).at(y=y) for y in spread(columns + 1, width - t)[1:-1]]
    if dice.chance(0.6):
        parts.append(board(0.01, 0.98 * width, height).at(0.005 - depth / 2))
    bay = width / columns - t
    for y in spread(columns, width * (1 - 1 / columns)):
        for level in range(levels):
            if dice.chance(filled):
                parts += shifted(_books(dice, depth, bay, pitch - t), y=y, z=level * pitch + t)
    return parts


def _books(dice: Dice, depth: float, width: float, height: float) -> Parts:
    """Return a row of 3 to 7 books from one side of a bay, or a stack of 2 to 4 lying ones."""
    if dice.chance(0.2):
        thick = min(0.045, 0.2 * height)
        count = dice.count(2, 4)
        return [
            board(0.7 * depth, min(0.25, 0.7 * width), 0.95 * thick).turned(dice.between(-0.2, 0.2)).at(z=k * thick)
            for k in range(count)
        ]
    y, parts = 0.02 - width / 2, []
    for _ in range(dice.count(3, 7)):
        thick, deep, tall = dice.between(0.02, 0.06), dice.between(0.55, 0.8) * depth, dice.between(0.55, 0.9) * height
        if y + thick > width / 2:
            break
        parts.append(board(deep, 0.94 * thick, tall, 0.002).at(0.03 - depth / 2 + deep / 2, y + thick / 2))
        y += thick
    return parts


def _a_frame(dice: Dice, depth: float, width: float, height: float, levels: int) -> Parts:
    """Return shelves between two leaning ladders."""
    foot, top = 1.3 * depth, 0.35 * depth
    r = dice.between(0.012, 0.02)
    rails = both_sides([rod((side * foot / 2, width / 2, 0.0), (side * top / 2, width / 2, height), r) for side in (1, -1)])
    shelves = []
    for level in range(levels):
        share = (level + 0.4) / levels
        shelves.append(board(foot + share * (top - foot), width + 0.03, 0.025).at(z=share * height))
    return [*rails, *shelves]

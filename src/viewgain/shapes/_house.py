"""Houses: front door towards +x."""

from math import pi

from viewgain.shapes._assemble import Parts, both_sides, shifted, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._primitives import board, cylinder, tapered, wedge


def house(dice: Dice) -> Parts:
    """Return a house: 5 to 10 m by 6 to 13 m without wing and porch, 1 to 3 floors of 2.5 to 3 m; uniform.

    Roof: gable (40 %), hip (20 %), flat with a parapet (16 %), shed, pyramid. A wing (35 %), a porch on 2 to 6 columns (45 %)
    with or without a balcony, 0 to 2 chimneys, 0 to 3 dormers (gables only), 0 to 3 steps; 2 to 5 windows a floor in front, 1 to
    4 behind, 0 to 3 beside.
    """
    depth, width = dice.between(5.0, 10.0), dice.between(6.0, 13.0)
    floors, storey = dice.count(1, 3), dice.between(2.5, 3.0)
    tall, slope = floors * storey, dice.between(0.45, 1.0)
    style = dice.pick(gable=0.4, hip=0.2, shed=0.12, flat=0.16, pyramid=0.12)
    parts = [board(depth, width, tall, 0.02), *_roof(dice, style, depth, width, slope)]
    parts[1:] = shifted(parts[1:], z=tall)
    parts += _openings(dice, depth, width, floors, storey)
    if dice.chance(0.35):
        wing_depth, wing_width = dice.between(0.5, 0.85) * depth, dice.between(3.5, 6.0)
        wing_tall = storey * dice.count(1, floors)
        block = [
            board(wing_depth, wing_width, wing_tall, 0.02),
            *shifted(_roof(dice, "gable" if style == "hip" else style, wing_depth, wing_width, 0.9 * slope), z=wing_tall),
        ]
        block.append(board(0.1, 0.6 * wing_width, 2.1).at(wing_depth / 2))
        parts += shifted(block, dice.between(-0.1, 0.3) * depth, (width + wing_width) / 2 - 0.2)
    for _ in range(dice.count(0, 2)):
        x, y = dice.between(-0.3, 0.3) * depth, dice.between(-0.4, 0.4) * width
        parts += [
            board(0.7, 0.9, 0.5 * slope * depth + 1.2).at(x, y, tall - 0.2),
            board(0.9, 1.1, 0.2).at(x, y, tall + 0.5 * slope * depth + 0.9),
        ]
    if style == "gable":
        parts += _dormers(dice, depth, width, tall, slope)
    return parts + (_porch(dice, depth, width, storey) if dice.chance(0.45) else [])


def _roof(dice: Dice, style: str, depth: float, width: float, slope: float) -> Parts:
    """Return a roof whose eaves lie on z = 0 and stand out a little; the ridge runs along y."""
    x, y, rise = depth + 0.8, width + 0.8, slope * depth / 2
    if style == "gable":
        return [wedge(x, y, rise)]
    if style == "shed":
        return [wedge(x, y, 0.8 * rise, -0.42 * depth)]
    if style == "hip":
        return [tapered((x, y), (0.02 * x, max(0.35 * y, y - x)), rise)]
    if style == "pyramid":
        return [tapered((x, y), (0.05 * x, 0.05 * y), 1.2 * rise)]
    walls = [board(0.25, width, 0.8).at(side * (depth / 2 - 0.12), z=-0.1) for side in (1, -1)]
    return [*walls, *both_sides([board(depth, 0.25, 0.8).at(y=width / 2 - 0.12, z=-0.1)])]


def _openings(dice: Dice, depth: float, width: float, floors: int, storey: float) -> Parts:
    """Return door, steps and windows, all standing out of the walls a little."""
    front, back, sides = dice.count(2, 5), dice.count(1, 4), dice.count(0, 3)
    pane = dice.between(0.7, 1.3)
    parts = [board(0.16, 1.1, 2.15).at(depth / 2)]
    steps = dice.count(0, 3)
    parts += [board(0.35 * (steps - k), 1.8, 0.17 * (k + 1)).at(depth / 2 + 0.17 * (steps - k)) for k in range(steps)]
    for floor in range(floors):
        z = floor * storey + 0.9
        parts += [
            board(0.14, pane, 1.2).at(depth / 2, y, z) for y in spread(front, 0.75 * width) if floor or abs(y) > 0.6 + pane / 2
        ]
        parts += [board(0.14, pane, 1.2).at(-depth / 2, y, z) for y in spread(back, 0.7 * width)]
        parts += both_sides([board(pane, 0.14, 1.2).at(x, width / 2, z) for x in spread(sides, 0.6 * depth)]) if sides else []
    return parts


def _dormers(dice: Dice, depth: float, width: float, tall: float, slope: float) -> Parts:
    """Return 0 to 3 dormers on the front of a gable roof."""
    count = dice.count(0, 3)
    if count == 0:
        return []
    wide, x, rise = dice.between(1.1, 1.6), 0.25 * depth, 0.8 * slope * depth / 2
    one = [board(0.35 * depth, wide, 0.8 * rise), wedge(1.2 * wide, 0.4 * depth, 0.45 * wide).turned(pi / 2).at(z=0.8 * rise)]
    return [part.at(x, y, tall + 0.1) for y in spread(count, 0.6 * width) for part in one]


def _porch(dice: Dice, depth: float, width: float, storey: float) -> Parts:
    """Return a roof on 2 to 6 columns before the door, with a balcony railing above it on some."""
    deep, wide, columns = dice.between(1.5, 2.8), dice.between(0.35, 1.0) * width, dice.count(2, 6)
    x, high = depth / 2 + deep, 0.95 * storey
    column = cylinder(0.14, high, 12) if dice.chance(0.5) else board(0.24, 0.24, high)
    parts = [board(deep + 0.3, wide, 0.22).at(depth / 2 + deep / 2, z=high), board(deep, wide, 0.2).at(depth / 2 + deep / 2)]
    parts += [column.at(x - 0.2, y) for y in spread(columns, wide - 0.5)]
    if dice.chance(0.35):
        parts.append(board(0.08, wide, 0.08).at(x, z=high + 1.0))
        parts += [board(0.05, 0.05, 0.85).at(x, y, high + 0.2) for y in spread(columns * 3, wide - 0.1)]
    return parts

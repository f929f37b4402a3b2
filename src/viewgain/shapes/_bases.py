"""What furniture stands on. Every base rises from z = 0 to ``height`` under a rectangle ``x`` by ``y`` about the origin."""

from math import atan2, cos, pi, sin

from viewgain.shapes._assemble import Parts, around, both_sides, shifted, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._lathe import lathe
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import rounded
from viewgain.shapes._primitives import board, cylinder, ellipsoid, frustum, tapered
from viewgain.shapes._sweep import rod, sweep


def legs(dice: Dice, x: float, y: float, height: float, *, thickness: float, pairs: int = 2) -> Parts:
    """Return ``2 pairs`` legs along the y sides, all alike: square, tapered, round, turned on a lathe, or splayed outwards."""
    style = dice.pick(square=0.3, tapered=0.2, round=0.2, turned=0.15, splayed=0.15)
    reach_x, reach_y = x / 2 - 0.7 * thickness, y / 2 - 0.7 * thickness
    places = [(side * reach_x, place) for side in (1, -1) for place in spread(pairs, 2 * reach_y)]
    if style == "splayed":
        lean = dice.between(0.05, 0.16) * height
        foot = dice.between(0.4, 0.8) * thickness / 2
        return [_splayed((px, py), lean, height, thickness / 2, foot) for px, py in places]
    leg = _leg(dice, style, height, thickness)
    return [leg.at(px, py) for px, py in places]


def _leg(dice: Dice, style: str, height: float, thickness: float) -> Part:
    """Return one upright leg."""
    if style == "square":
        return board(thickness, thickness, height)
    if style == "tapered":
        foot = dice.between(0.45, 0.75) * thickness
        return tapered((foot, foot), (thickness, thickness), height)
    if style == "round":
        return frustum(dice.between(0.3, 0.5) * thickness, thickness / 2, height, 12)
    r, knots = thickness / 2, dice.count(2, 4)
    beads = [
        (share * r, (0.1 + 0.6 * (k + dz) / knots) * height)
        for k in range(knots)
        for share, dz in ((0.55, 0.0), (0.9, 0.3), (0.9, 0.5), (0.5, 0.8))
    ]
    return lathe([(0.6 * r, 0.0), (0.75 * r, 0.04 * height), *beads, (r, 0.78 * height), (r, height)], 10)


def _splayed(at: tuple[float, float], lean: float, height: float, radius: float, foot: float) -> Part:
    """Return one round leg whose foot stands ``lean`` farther out than its top."""
    x, y = at
    way = atan2(y, x)
    return rod((x + lean * cos(way), y + lean * sin(way), 0.0), (x, y, height), foot, radius, 10)


def stretchers(dice: Dice, x: float, y: float, height: float, *, thickness: float) -> Parts:
    """Return the bars between four legs near the floor: none (half of the time), an H, a box, or the two sides only."""
    style = dice.pick(none=0.5, h=0.2, box=0.15, sides=0.15)
    if style == "none":
        return []
    z = dice.between(0.2, 0.45) * height
    reach_x, reach_y = x - 1.4 * thickness, y - 1.4 * thickness
    along = [board(reach_x, 0.5 * thickness, 0.6 * thickness).at(y=side * reach_y / 2, z=z) for side in (1, -1)]
    across = board(0.5 * thickness, reach_y, 0.6 * thickness)
    if style == "h":
        return [*along, across.at(z=z)]
    return along if style == "sides" else [*along, across.at(reach_x / 2, z=z), across.at(-reach_x / 2, z=z)]


def pedestal(dice: Dice, x: float, y: float, height: float) -> Parts:
    """Return a central column on a round plate, a cross of 3 to 5 arms, or a heavy block."""
    radius = dice.between(0.035, 0.08)
    spread_out = dice.between(0.6, 0.8) * min(x, y) / 2
    foot = dice.pick(disc=0.4, cross=0.4, block=0.2)
    if foot == "disc":
        return [
            lathe([(spread_out, 0.0), (spread_out, 0.02), (1.6 * radius, 0.05), (radius, 0.09), (radius, height)], 24),
        ]
    if foot == "cross":
        return [cylinder(radius, height - 0.04, 12).at(z=0.04), *_arms(dice.count(3, 5), spread_out, 0.06)]
    return [board(1.3 * spread_out, 1.3 * spread_out, 0.06), board(2 * radius, 2 * radius, height)]


def star(dice: Dice, x: float, y: float, height: float) -> Parts:
    """Return the foot of an office chair: a gas spring on 4 to 6 arms, on castors (70 %) or pads."""
    arms, reach = dice.count(4, 6), dice.between(0.55, 0.68) * max(x, y)
    wheel = 0.028 if dice.chance(0.7) else 0.0
    feet = around(ellipsoid(0.05, 0.03, 0.056, 4, 8).at(reach - 0.03, z=0.028), arms, pi / 4) if wheel else []
    column = lathe([(0.035, wheel + 0.03), (0.035, 0.55 * height), (0.022, 0.56 * height), (0.022, height)], 12)
    return [column, *shifted(_arms(arms, reach, 0.07), z=1.4 * wheel), *feet]


def _arms(count: int, reach: float, root: float) -> Parts:
    """Return bars that run out from the axis along the floor, sloping down to their tips."""
    arm = tapered((reach, 0.035), (0.5 * reach, 0.03), root, (-0.25 * reach, 0.0)).at(reach / 2)
    return around(arm, count, pi / 4)


def sled(dice: Dice, x: float, y: float, height: float) -> Parts:
    """Return two frames of bent tube with runners on the floor; open behind (a cantilever) 40 % of the time."""
    radius, bend = dice.between(0.009, 0.014), dice.between(0.03, 0.1)
    y_side, front, back = y / 2 - radius, x / 2 - radius, -x / 2 + radius
    low, high = radius, height - radius
    path = [(back, y_side, high), (front, y_side, high), (front, y_side, low), (back, y_side, low)]
    if dice.chance(0.4):
        return [sweep(rounded([*path, (back, -y_side, low), *_across(path)], bend), unit_circle(8) * radius)]
    frame = sweep(rounded([*path, (back, y_side, high - 1e-3)], bend), unit_circle(8) * radius)
    bar = rod((0.0, -y_side, high), (0.0, y_side, high), radius)
    return [*both_sides([frame]), bar]


def _across(path: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """Return the other half of a symmetric path, from the middle to its end."""
    return [(px, -py, pz) for px, py, pz in path[::-1]][1:]


def panels(dice: Dice, x: float, y: float, height: float) -> Parts:
    """Return two upright panels at the ends of y, with a beam between them half of the time."""
    thickness = dice.between(0.025, 0.05)
    sides = both_sides([board(dice.between(0.75, 0.95) * x, thickness, height).at(y=0.47 * y - thickness / 2)])
    z = dice.between(0.35, 0.75) * height
    return [*sides, board(0.03, 0.9 * y, 0.2 * height).at(z=z)] if dice.chance(0.5) else sides


def trestles(dice: Dice, x: float, y: float, height: float) -> Parts:
    """Return two frames at the ends of y, crossed like an X or spread like an A, joined by a beam."""
    place, thickness = dice.between(0.32, 0.42) * y, dice.between(0.04, 0.07)
    foot, z = 0.42 * x, dice.between(0.25, 0.55) * height
    top = -foot if dice.chance(0.5) else 0.12 * x
    end = (thickness, 0.8 * thickness)
    bars = [tapered(end, end, height, (side * (top - foot), 0.0)).at(side * foot, place) for side in (1, -1)]
    return [*both_sides(bars), board(thickness, 2 * place, thickness).at(z=z)]

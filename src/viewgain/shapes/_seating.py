"""Chairs, benches and sofas: front towards +x."""

from viewgain.shapes import _bases as bases
from viewgain.shapes._assemble import Parts, both_sides, shifted, spread, turned
from viewgain.shapes._backs import armrests, backrest
from viewgain.shapes._dice import Dice
from viewgain.shapes._extrude import extrude
from viewgain.shapes._outline import ellipse, rectangle
from viewgain.shapes._part import Part
from viewgain.shapes._primitives import board, cushion, cylinder


def chair(dice: Dice) -> Parts:
    """Return a chair: seat 0.38 to 0.56 m wide and 0.40 to 0.52 m high, its back rising 0.25 to 0.65 m above it; uniform.

    Base: four legs (50 %), with or without stretchers; bent tube (20 %), star on castors (18 %), pedestal (12 %). Seat: board (35
    %), rounded (30 %), cushion (25 %), disc (10 %). Back: none (5 %), else any of :func:`backrest`, leaning up to 0.25 rad. Arms:
    37 % of those with a back and no disc.
    """
    depth, width, height = dice.between(0.38, 0.52), dice.between(0.38, 0.56), dice.between(0.40, 0.52)
    seat, thickness, disc = _seat(dice, depth, width)
    under = height - 0.9 * thickness
    style = dice.pick(legs=0.5, star=0.18, sled=0.2, pedestal=0.12)
    parts = [seat.at(z=height - thickness)]
    if style == "legs":
        leg = dice.between(0.03, 0.055)
        parts += bases.legs(dice, depth, width, under, thickness=leg)
        parts += bases.stretchers(dice, depth, width, under, thickness=leg)
    else:
        parts += {"star": bases.star, "sled": bases.sled, "pedestal": bases.pedestal}[style](dice, depth, width, under)
    rise = dice.between(0.25, 0.65)
    if dice.chance(0.95):
        back = turned(backrest(dice, dice.between(0.8, 1.0) * width, rise), -dice.between(0.0, 0.25), "y")
        parts += shifted(back, 0.03 - depth / 2, z=height - 0.02)
        arms = dice.chance(0.37)
        parts += (
            [] if disc or not arms else shifted(armrests(dice, depth, width, min(dice.between(0.16, 0.26), 0.8 * rise)), z=height)
        )
    return parts


def _seat(dice: Dice, depth: float, width: float) -> tuple[Part, float, bool]:
    """Return a seat, its thickness, and whether it is a disc."""
    style = dice.pick(board=0.35, rounded=0.3, round=0.1, cushion=0.25)
    if style == "cushion":
        thickness = dice.between(0.06, 0.11)
        return cushion(depth, width, thickness, dice.between(0.2, 0.4)), thickness, False
    thickness = dice.between(0.018, 0.045)
    if style == "board":
        return board(depth, width, thickness), thickness, False
    outline = ellipse(depth, width) if style == "round" else rectangle(depth, width, dice.between(0.05, 0.16), 4)
    return extrude(outline, thickness, bevel=thickness / 5), thickness, style == "round"


def bench(dice: Dice) -> Parts:
    """Return a bench: 0.9 to 2.0 m long, 0.32 to 0.5 m deep, 0.40 to 0.50 m high; uniform.

    Seat: one board (40 %), 2 to 6 planks (40 %), 8 to 20 slats across (20 %). Base: 2 or 3 pairs of legs (40 %), panels (25 %),
    trestles (20 %), tubes (15 %). Back: 45 %, of 1 to 4 planks or any chair's back; arms on half of these.
    """
    depth, length, height = dice.between(0.32, 0.5), dice.between(0.9, 2.0), dice.between(0.40, 0.50)
    thickness = dice.between(0.025, 0.06)
    parts = shifted(_bench_seat(dice, depth, length, thickness), z=height - thickness)
    style = dice.pick(panels=0.25, trestles=0.2, sled=0.15, legs=0.4)
    under = height - 0.9 * thickness
    if style == "legs":
        leg = dice.between(0.04, 0.08)
        parts += bases.legs(dice, depth, length, under, thickness=leg, pairs=dice.count(2, 3))
        parts += bases.stretchers(dice, depth, length, under, thickness=leg)
    else:
        parts += {"panels": bases.panels, "trestles": bases.trestles, "sled": bases.sled}[style](dice, depth, length, under)
    if dice.chance(0.45):
        rise = dice.between(0.3, 0.5)
        back = _plank_back(dice, length, rise) if dice.chance(0.6) else backrest(dice, length, rise)
        parts += shifted(turned(back, -dice.between(0.0, 0.25), "y"), 0.02 - depth / 2, z=height - 0.03)
        if dice.chance(0.5):
            parts += shifted(armrests(dice, depth, length - 0.08, dice.between(0.16, 0.25)), z=height)
    return parts


def _bench_seat(dice: Dice, depth: float, length: float, thickness: float) -> Parts:
    """Return the seat as one board or as slats on two bearers."""
    style = dice.pick(board=0.4, planks=0.4, slats=0.2)
    if style == "board":
        return [board(depth, length, thickness)]
    bearers = both_sides([board(depth - 0.02, 0.05, 0.05).at(y=0.38 * length, z=-0.045)])
    if style == "planks":
        count = dice.count(2, 6)
        plank = board(dice.between(0.75, 0.92) * depth / count, length, thickness)
        return [*bearers, *(plank.at(x) for x in spread(count, depth * (1 - 1 / count)))]
    count = dice.count(8, 20)
    slat = board(depth, dice.between(0.4, 0.75) * length / count, thickness)
    rails = [board(0.04, length, 0.04).at(x, z=-0.03) for x in (0.3 * depth, -0.3 * depth)]
    return [*rails, *(slat.at(y=y) for y in spread(count, length * (1 - 1 / count)))]


def _plank_back(dice: Dice, length: float, rise: float) -> Parts:
    """Return 2 or 3 posts that carry 1 to 4 planks."""
    count, pitch = dice.count(1, 4), 0.0
    pitch = 0.75 * rise / count
    posts = [board(0.03, 0.05, rise).at(-0.02, y) for y in spread(dice.count(2, 3), 0.85 * length)]
    plank = board(0.025, length, dice.between(0.6, 0.85) * pitch)
    return [*posts, *(plank.at(z=0.22 * rise + k * pitch) for k in range(count))]


def sofa(dice: Dice) -> Parts:
    """Return a sofa: 1 to 4 seats of 0.52 to 0.68 m, 0.72 to 0.92 m deep, seat 0.36 to 0.46 m high; uniform.

    Arms: blocks (35 %), rolls (30 %), slim panels (20 %) or none. A cushion per seat at the back (70 %); a chaise (25 % of those
    with several seats), 0.5 to 0.75 m longer; a plinth (25 %) or feet.
    """
    seats = dice.count(1, 4)
    width, depth = seats * dice.between(0.52, 0.68), dice.between(0.72, 0.92)
    height, rise, foot = dice.between(0.36, 0.46), dice.between(0.32, 0.5), dice.between(0.05, 0.16)
    cushion_height, soft = dice.between(0.12, 0.18), dice.between(0.2, 0.4)
    base_top, back_depth = height - 0.6 * cushion_height, dice.between(0.14, 0.24)
    arm, arm_width, arm_parts = _sofa_arm(dice, depth, base_top - foot)
    parts = [board(depth, width, base_top - foot, 0.02).at(z=foot)]
    parts += both_sides(shifted(arm_parts, y=(width + arm_width) / 2 - 0.005, z=foot)) if arm != "none" else []
    parts.append(board(back_depth, width, height + rise - foot - 0.06, 0.03).at(back_depth / 2 - depth / 2, z=foot))
    seat_depth = depth - back_depth
    places = spread(seats, width * (1 - 1 / seats))
    parts += [
        cushion(seat_depth, width / seats, cushion_height, soft).at(back_depth / 2, y, height - cushion_height) for y in places
    ]
    if dice.chance(0.7):
        pad = cushion(0.2, 0.96 * width / seats, rise, soft).turned(-dice.between(0.1, 0.3), "y")
        parts += [pad.at(back_depth - depth / 2 + 0.1, y, height - 0.02) for y in places]
    if seats > 1 and dice.chance(0.25):
        reach = dice.between(0.5, 0.75)
        y = places[-1]
        parts.append(board(reach + 0.05, width / seats, base_top - foot, 0.02).at(depth / 2 + reach / 2 - 0.025, y, foot))
        parts.append(
            cushion(reach + 0.05, width / seats, cushion_height, soft).at(
                depth / 2 + reach / 2 - 0.025, y, height - cushion_height
            )
        )
    if dice.chance(0.25):
        return [*parts, board(0.9 * depth, 0.95 * width, foot + 0.01)]
    return parts + bases.legs(dice, 0.9 * depth, width, foot + 0.01, thickness=0.05, pairs=2 if seats < 3 else 3)


def _sofa_arm(dice: Dice, depth: float, base: float) -> tuple[str, float, Parts]:
    """Return the style, the width and the parts of one arm, centred on y = 0 and standing on z = 0."""
    style = dice.pick(block=0.35, roll=0.3, slim=0.2, none=0.15)
    width = dice.between(0.12, 0.25) if style != "slim" else dice.between(0.05, 0.08)
    rise = base + dice.between(0.15, 0.3)
    if style == "roll":
        roll = cylinder(0.55 * width, depth, 16).turned(1.5707963267948966, "y").at(-depth / 2, z=rise - 0.55 * width)
        return style, width, [board(0.98 * depth, 0.9 * width, rise - 0.4 * width), roll]
    return style, width, [board(depth, width, rise, 0.2 * width)]

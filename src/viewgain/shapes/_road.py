"""Cars and buses: nose towards +x."""

from math import pi

from viewgain.shapes._assemble import Parts, both_sides, spread
from viewgain.shapes._dice import Dice
from viewgain.shapes._extrude import side_profile
from viewgain.shapes._outline import unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import rounded, rounded_loop
from viewgain.shapes._primitives import block, board, ellipsoid, tapered
from viewgain.shapes._sweep import rod, sweep
from viewgain.shapes._wheels import axles, wheel

_CABINS = {
    "sedan": (0.56, 0.30, -0.04),
    "hatchback": (0.66, 0.44, -0.13),
    "estate": (0.72, 0.56, -0.13),
    "coupe": (0.50, 0.20, -0.06),
    "suv": (0.70, 0.56, -0.11),
    "pickup": (0.36, 0.24, 0.04),
    "van": (0.80, 0.66, -0.08),
}
"""Length of the cabin at the waist and at the roof, and place of its middle, as shares of the car's length."""


def car(dice: Dice) -> Parts:
    """Return a car: body 3.6 to 4.9 m long and 1.6 to 1.9 m wide, 1.2 to 1.9 m high; uniform within each kind.

    Kinds: sedan and hatchback (18 % each), suv (14 %), estate and coupe (12 % each), pickup and van (10 % each), convertible (6
    %). Bumpers (60 %), lights round (40 %) or long (40 %), exhausts (30 %), a rear wing, a spare wheel, a roll bar.
    """
    kind = dice.pick(sedan=0.18, hatchback=0.18, estate=0.12, coupe=0.12, suv=0.14, pickup=0.1, van=0.1, convertible=0.06)
    length, width = dice.between(3.6, 4.9), dice.between(1.6, 1.9)
    high = kind in ("suv", "van", "pickup")
    radius = dice.between(0.33, 0.42) if high else dice.between(0.28, 0.35)
    ground, waist = radius * dice.between(0.5, 0.75), radius + dice.between(0.42, 0.58)
    parts = [_body(dice, kind, length, width, ground=ground, waist=waist)]
    base = dice.between(0.56, 0.64) * length
    parts += axles([base / 2, -base / 2 + 0.01 * length], width + 0.02, radius, dice.between(0.19, 0.27))
    if kind == "convertible":
        parts += _open_cabin(dice, length, width, waist)
    else:
        rise = dice.between(0.5, 0.62) if kind != "van" else dice.between(0.65, 0.95)
        parts += _cabin(dice, kind, length, width, waist=waist, rise=rise)
    return parts + _fittings(dice, kind, length, width, waist)


def _body(dice: Dice, kind: str, length: float, width: float, *, ground: float, waist: float) -> Part:
    """Return the lower body: a side view with a hood and a tail, pulled across the width."""
    nose, tail = length / 2, -length / 2
    hood = waist - dice.between(0.05, 0.16)
    boot = waist - dice.between(0.0, 0.1) if kind in ("sedan", "coupe", "convertible") else waist
    mid = (ground + waist) / 2
    outline = rounded_loop(
        [(tail + 0.1, ground), (nose - 0.15, ground), (nose, mid - 0.1), (nose - 0.08, hood - 0.06),
         (0.28 * length, waist - 0.02), (-0.3 * length, waist), (tail + 0.04, boot), (tail, mid)], 0.12
    )  # fmt: skip
    return side_profile(outline, width, bevel=0.06, centre=(0.0, mid))


def _cabin(dice: Dice, kind: str, length: float, width: float, *, waist: float, rise: float) -> Parts:
    """Return the glasshouse, and the bed walls of a pickup."""
    low, high, middle = (share * length for share in _CABINS[kind])
    lean = dice.between(-0.02, 0.02) * length + {"sedan": 0.0, "coupe": -0.02}.get(kind, -0.05) * length
    lower, upper = 0.94 * width, dice.between(0.7, 0.84) * width
    glass = tapered((low, lower), (high, upper), 0.93 * rise, (lean, 0.0)).at(middle, z=waist - 0.04)
    roof = board(1.04 * high, 1.03 * upper, 0.08, 0.03).at(middle + lean, z=waist - 0.04 + 0.9 * rise)
    parts = [glass, roof]
    if kind == "pickup":
        bed = middle - low / 2 + length / 2
        walls = [board(bed, 0.07, 0.3).at(bed / 2 - length / 2, 0.46 * width, waist - 0.06)]
        parts += [*both_sides(walls), board(0.07, 0.9 * width, 0.3).at(0.06 - length / 2, z=waist - 0.06)]
        if dice.chance(0.4):
            hoop = [(0, -0.4 * width, 0), (0, -0.4 * width, rise), (0, 0.4 * width, rise), (0, 0.4 * width, 0)]
            parts.append(sweep(rounded(hoop, 0.15), unit_circle(8) * 0.035).at(middle - low / 2 - 0.12, z=waist - 0.05))
    return parts


def _open_cabin(dice: Dice, length: float, width: float, waist: float) -> Parts:
    """Return windscreen, seats and perhaps roll bars of a convertible."""
    frame = [(0.02 * length, -0.42 * width, 0), (-0.08 * length, -0.36 * width, 0.38), (-0.08 * length, 0.36 * width, 0.38),
             (0.02 * length, 0.42 * width, 0)]  # fmt: skip
    parts = [sweep(rounded(frame, 0.1), unit_circle(8) * 0.03).at(0.14 * length, z=waist - 0.05)]
    for row in range(dice.count(1, 2)):
        x = -0.06 * length - 0.17 * length * row
        parts += both_sides([board(0.14, 0.5, 0.45, 0.05).turned(-0.25, "y").at(x, 0.22 * width, waist - 0.08)])
        parts += both_sides([ellipsoid(0.12, 0.28, 0.18).at(x - 0.12, 0.22 * width, waist + 0.42)])
    return parts


def _fittings(dice: Dice, kind: str, length: float, width: float, waist: float) -> Parts:
    """Return the small things that tell cars apart."""
    parts = both_sides([ellipsoid(0.14, 0.2, 0.14, 6, 10).at(0.17 * length, width / 2 + 0.04, waist + 0.08)])
    if dice.chance(0.6):
        parts += [board(0.2, 0.96 * width, 0.16, 0.05).at(side * (length / 2 - 0.04), z=0.32) for side in (1, -1)]
    lights = dice.pick(round=0.4, long=0.4, none=0.2)
    if lights == "round":
        parts += both_sides([ellipsoid(0.12, 0.22, 0.2, 6, 12).at(length / 2 - 0.05, 0.36 * width, waist - 0.26)])
    elif lights == "long":
        parts += both_sides([board(0.1, 0.4, 0.1).at(length / 2 - 0.06, 0.33 * width, waist - 0.3)])
    if kind in ("sedan", "coupe", "hatchback") and dice.chance(0.25):
        wing = board(0.25, 0.85 * width, 0.04).at(0.16 - length / 2, z=waist + 0.16)
        parts += [wing, *both_sides([board(0.1, 0.04, 0.28).at(0.16 - length / 2, 0.3 * width, waist - 0.1)])]
    if kind == "suv" and dice.chance(0.4):
        parts.append(wheel(0.32, 0.2).turned(pi / 2).at(-length / 2 - 0.08, z=waist - 0.15))
    if dice.chance(0.3):
        parts += both_sides([rod((-length / 2 - 0.05, 0.3 * width, 0.28), (-length / 2 + 0.3, 0.3 * width, 0.28), 0.04)])
    return parts


def bus(dice: Dice) -> Parts:
    """Return a bus: 5.5 to 13 m long (to 20 m articulated), 2.2 to 2.55 m wide without mirrors, 2.6 to 4.5 m high; uniform.

    Kinds: single deck (40 %), double deck (20 %), school bus with a hood (15 %), minibus (15 %), articulated (10 %). 2 to 4
    axles, 4 to 12 windows a side and deck, 1 to 3 doors, a roof unit (50 %), mirrors (70 %).
    """
    kind = dice.pick(single=0.4, double=0.2, school=0.15, articulated=0.1, mini=0.15)
    length = {"mini": dice.between(5.5, 7.0), "school": dice.between(8.0, 11.0)}.get(kind, dice.between(9.5, 13.0))
    width, radius, ground = dice.between(2.2, 2.55), dice.between(0.42, 0.52), dice.between(0.28, 0.4)
    roof = {"double": dice.between(3.9, 4.3), "mini": dice.between(2.6, 2.9)}.get(kind, dice.between(2.9, 3.3))
    parts = _coach(dice, length, width, ground, roof, decks=2 if kind == "double" else 1)
    back = (
        [-0.28 * length] if kind in ("mini", "school") or dice.chance(0.5) else [-0.22 * length, -0.22 * length - 2.15 * radius]
    )
    front = 0.33 * length
    if kind == "school":
        hood = dice.between(1.2, 1.8)
        parts.append(tapered((hood, 0.9 * width), (hood, 0.8 * width), 0.3 * roof).at((length + hood) / 2 - 0.02, z=ground))
        front = length / 2 + 0.4 * hood
    parts += axles([front, *back], width + 0.04, radius, 0.32)
    if kind == "articulated":
        rear = dice.between(4.5, 6.0)
        middle = -length / 2 - 0.7 - rear / 2
        parts += [
            board(0.3, 0.94 * width, 0.9 * (roof - ground), 0.05).at(-length / 2 - 0.12 - 0.23 * k, z=ground + 0.1)
            for k in range(3)
        ]
        parts += [part.at(middle) for part in _coach(dice, rear, width, ground, roof, decks=1)]
        parts += axles([middle], width + 0.04, radius, 0.32)
    if dice.chance(0.5):
        parts.append(board(dice.between(1.2, 2.5), 0.7 * width, 0.22, 0.06).at(dice.between(-0.3, 0.2) * length, z=roof - 0.02))
    if dice.chance(0.7):
        arm = rod((length / 2 - 0.2, width / 2 - 0.1, 0.7 * roof), (length / 2 + 0.2, width / 2 + 0.15, 0.75 * roof), 0.03)
        parts += both_sides([arm, board(0.08, 0.2, 0.4).at(length / 2 + 0.2, width / 2 + 0.2, 0.6 * roof)])
    return parts


def _coach(dice: Dice, length: float, width: float, ground: float, roof: float, *, decks: int) -> Parts:
    """Return a long box with raised window panes on both sides and doors on its right (-y)."""
    outline = rounded_loop(
        [(-length / 2, ground), (length / 2, ground), (length / 2, 0.6 * roof), (length / 2 - dice.between(0.05, 0.35), roof),
         (-length / 2 + 0.1, roof), (-length / 2, 0.6 * roof)], 0.25
    )  # fmt: skip
    parts = [side_profile(outline, width, bevel=0.08, centre=(0.0, (ground + roof) / 2))]
    count = dice.count(4, 7) if length < 8 else dice.count(5, 12)
    for deck in range(decks):
        tall = (roof - ground) / decks
        low = ground + (deck + (0.42 if decks == 1 else 0.35)) * tall
        pane = block(dice.between(0.7, 0.9) * 0.92 * length / count, 0.04, 0.42 * tall)
        parts += both_sides([pane.at(x, width / 2, low) for x in spread(count, 0.92 * length * (1 - 1 / count))])
        parts += [block(0.04, 0.84 * width, 0.45 * tall).at(side * (length / 2 - 0.02), z=low) for side in (1, -1)]
    door = board(0.9, 0.06, min(0.8 * (roof - ground), 2.0), 0.015)
    doors = dice.count(1, 3)
    return parts + [door.at(0.42 * length - k * 0.36 * length, -width / 2, ground + 0.06) for k in range(doors)]

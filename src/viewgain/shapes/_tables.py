"""Tables and beds."""

from viewgain.shapes import _bases as bases
from viewgain.shapes._assemble import Parts, both_sides, shifted, spread
from viewgain.shapes._backs import backrest
from viewgain.shapes._dice import Dice
from viewgain.shapes._extrude import extrude, front_profile
from viewgain.shapes._outline import ellipse, rectangle, superellipse
from viewgain.shapes._part import Part
from viewgain.shapes._primitives import board, cushion, cylinder, ellipsoid
from viewgain.shapes._sweep import rod


def table(dice: Dice) -> Parts:
    """Return a table: top 0.5 to 1.1 m by 0.6 to 2.0 m, 0.38 to 0.78 m high (coffee table to desk); uniform.

    Top: rectangle (35 %), rounded (20 %), round (20 %), oval (15 %), superellipse (10 %). Base: legs (45 %), pedestal (20 %; two
    under long tops), trestles, panels, tubes. Under legs an apron (60 %), a lower shelf (20 %) or stretchers, 1 to 3 drawers (20
    %).
    """
    depth, length, height = dice.between(0.5, 1.1), dice.between(0.6, 2.0), dice.between(0.38, 0.78)
    length = max(length, depth)
    shape = dice.pick(square=0.35, rounded=0.2, round=0.2, oval=0.15, superellipse=0.1)
    thickness = dice.between(0.018, 0.05)
    if shape == "round":
        length = depth
    under = height - 0.9 * thickness
    parts = [_top(dice, shape, depth, length, thickness).at(z=height - thickness)]
    fit = 0.95 if shape in ("square", "rounded") else 0.66
    x, y = fit * depth, fit * length
    style = dice.pick(legs=0.45, pedestal=0.2, trestles=0.12, panels=0.12, sled=0.11)
    if style == "legs":
        return parts + _legged(dice, x, y, under)
    if style == "pedestal" and length > 1.5 * depth:
        column = bases.pedestal(dice, depth, depth, under)
        return [*parts, *shifted(column, y=0.25 * length), *shifted(column, y=-0.25 * length)]
    build = {"pedestal": bases.pedestal, "trestles": bases.trestles, "panels": bases.panels, "sled": bases.sled}[style]
    return parts + build(dice, x, y, under)


def _top(dice: Dice, shape: str, depth: float, length: float, thickness: float) -> Part:
    """Return the table top."""
    if shape == "square":
        return board(depth, length, thickness)
    if shape == "rounded":
        return extrude(rectangle(depth, length, dice.between(0.05, 0.2), 5), thickness, bevel=thickness / 5)
    if shape == "superellipse":
        return extrude(superellipse(depth, length, dice.between(2.6, 4.0), 40), thickness, bevel=thickness / 5)
    return extrude(ellipse(depth, length, dice.count(16, 20) * 2), thickness, bevel=thickness / 5)


def _legged(dice: Dice, x: float, y: float, under: float) -> Parts:
    """Return four legs and what hangs between them."""
    leg = dice.between(0.035, 0.08)
    parts = bases.legs(dice, x, y, under, thickness=leg, pairs=3 if y > 1.6 and dice.chance(0.3) else 2)
    apron = dice.between(0.06, 0.12)
    if dice.chance(0.6):
        parts += both_sides([board(x - 2 * leg, 0.02, apron).at(y=y / 2 - leg, z=under - apron)])
        parts += [board(0.02, y - 2 * leg, apron).at(side * (x / 2 - leg), z=under - apron) for side in (1, -1)]
    if dice.chance(0.2):
        parts.append(board(x - 2 * leg, y - leg, 0.02).at(z=dice.between(0.15, 0.4) * under))
    else:
        parts += bases.stretchers(dice, x, y, under, thickness=leg)
    if dice.chance(0.2):
        width, tall = 0.25 * y, dice.between(0.3, 0.85) * under
        parts.append(board(0.85 * x, width, tall).at(y=y / 2 - leg - width / 2, z=under - tall))
        drawers = dice.count(1, 3)
        front = board(0.02, 0.9 * width, 0.85 * tall / drawers)
        levels = [under - tall + (k + 0.08) * tall / drawers for k in range(drawers)]
        parts += [front.at(0.43 * x, y / 2 - leg - width / 2, z) for z in levels]
    return parts


def bed(dice: Dice) -> Parts:
    """Return a bed, head at -x: 1.9 to 2.15 m long, 0.85 to 1.9 m wide, mattress top at 0.4 to 0.65 m; uniform.

    1 or 2 columns and 1 or 2 rows of pillows; a blanket (50 %). A bunk with a ladder (35 % of those under 1.2 m). Else a
    headboard (panel, arch, bars, pads), a footboard (40 %), four posts with rails (15 %); legs (50 %), plinth or drawers below.
    """
    length, width, top = dice.between(1.9, 2.15), dice.between(0.85, 1.9), dice.between(0.4, 0.65)
    bunk = width < 1.2 and dice.chance(0.35)
    parts = _lying(dice, length, width, top)
    if bunk:
        rise = dice.between(0.85, 1.05)
        parts += shifted(_lying(dice, length, width, top), z=rise)
        return parts + _bunk_posts(dice, length, width, top + rise)
    low = top - 0.3
    under = dice.pick(legs=0.5, plinth=0.25, drawers=0.25)
    if under == "legs":
        parts += bases.legs(dice, length, width, low + 0.02, thickness=dice.between(0.06, 0.1), pairs=2)
    else:
        parts.append(board(0.94 * length, 0.9 * width, low + 0.02))
        if under == "drawers":
            count = dice.count(2, 4)
            front = board(0.85 * length / count, 0.03, 0.85 * low + 0.01)
            parts += both_sides([front.at(x, 0.45 * width, 0.01) for x in spread(count, 0.9 * length * (1 - 1 / count))])
    parts += shifted(_headboard(dice, width, top + dice.between(0.25, 0.6)), -length / 2)
    if dice.chance(0.4):
        parts += shifted(_headboard(dice, width, top + dice.between(0.0, 0.2)), length / 2)
    if dice.chance(0.15):
        parts += _canopy(dice, length, width)
    return parts


def _lying(dice: Dice, length: float, width: float, top: float) -> Parts:
    """Return frame, mattress, pillows and perhaps a blanket."""
    thick = dice.between(0.16, 0.24)
    parts = [board(length, width, 0.14).at(z=top - 0.3), cushion(0.97 * length, 0.95 * width, thick, 0.2).at(z=top - thick)]
    columns, rows = (1 if width < 1.15 else 2), dice.count(1, 2)
    pillow = cushion(0.4, 0.85 * width / columns, 0.14, dice.between(0.4, 0.7))
    for row in range(rows):
        parts += [pillow.at(0.26 - length / 2 + 0.22 * row, y, top - 0.04 + 0.03 * row) for y in spread(columns, 0.48 * width)]
    if dice.chance(0.5):
        cover = dice.between(0.4, 0.65) * length
        parts.append(cushion(cover, 1.03 * width, thick + 0.05, 0.18).at(0.49 * length - cover / 2, z=top - thick - 0.02))
    return parts


def _headboard(dice: Dice, width: float, height: float) -> Parts:
    """Return an upright end, standing on the floor."""
    style = dice.pick(panel=0.3, arch=0.2, bars=0.3, padded=0.2)
    if style == "panel":
        return [board(dice.between(0.03, 0.08), width, height)]
    if style == "arch":
        outline = superellipse(width, 2 * height, dice.between(2.0, 5.0), 40)
        half = outline[outline[:, 1] >= -1e-9]
        return [front_profile(half, 0.05, centre=(0.0, 0.4 * height)).at(-0.025)]
    if style == "padded":
        count = dice.count(1, 4)
        pads = [
            cushion(0.1, 0.98 * width / count, 0.6 * height, 0.3).at(0.03, y, 0.4 * height)
            for y in spread(count, width * (1 - 1 / count))
        ]
        return [board(0.04, width, 0.95 * height), *pads]
    return shifted(backrest(dice, width, 0.75 * height), z=0.25 * height) + both_sides(
        [board(0.04, 0.04, 0.3 * height).at(y=0.47 * width)]
    )


def _bunk_posts(dice: Dice, length: float, width: float, top: float) -> Parts:
    """Return four high posts, rails around the upper bed and a ladder."""
    post, high = dice.between(0.05, 0.09), top + dice.between(0.25, 0.4)
    x, y = length / 2, width / 2
    parts = both_sides([board(post, post, high).at(side * x, y) for side in (1, -1)])
    for z in (top + 0.1, high - 0.06):
        parts += both_sides([board(length, 0.025, 0.05).at(y=y, z=z)])
        parts += [board(0.025, width, 0.05).at(side * x, z=z) for side in (1, -1)]
    place, rungs = dice.between(-0.2, 0.35) * length, dice.count(4, 7)
    ladder = [board(0.04, 0.03, top).at(place + side * 0.18, y + 0.05) for side in (1, -1)]
    return parts + ladder + [rod((place - 0.18, y + 0.05, z), (place + 0.18, y + 0.05, z), 0.016) for z in _rungs(rungs, top)]


def _rungs(count: int, top: float) -> list[float]:
    """Return the heights of a ladder's rungs."""
    return [top * (k + 1) / (count + 0.5) for k in range(count)]


def _canopy(dice: Dice, length: float, width: float) -> Parts:
    """Return four tall posts joined by rails, with balls on top half of the time."""
    high, r = dice.between(1.7, 2.1), dice.between(0.025, 0.04)
    x, y = length / 2, width / 2
    parts = both_sides([cylinder(r, high, 12).at(side * x, y) for side in (1, -1)])
    if dice.chance(0.5):
        parts += both_sides([ellipsoid(4 * r, 4 * r, 4 * r).at(side * x, y, high) for side in (1, -1)])
    rails = [rod((-x, y, 0.96 * high), (x, y, 0.96 * high), 0.6 * r)]
    return [*parts, *both_sides(rails), *(rod((s * x, -y, 0.96 * high), (s * x, y, 0.96 * high), 0.6 * r) for s in (1, -1))]

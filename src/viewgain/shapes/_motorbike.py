"""Motorbikes: the way of travel is +x."""

import numpy as np

from viewgain.shapes._assemble import Parts, both_sides
from viewgain.shapes._dice import Dice
from viewgain.shapes._outline import rectangle, superellipse, unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import rounded, smooth
from viewgain.shapes._primitives import board, cushion, cylinder, ellipsoid, tapered
from viewgain.shapes._sweep import rod, sweep
from viewgain.shapes._wheels import spoked


def motorbike(dice: Dice) -> Parts:
    """Return a motorbike: 1.8 to 2.4 m long, 0.57 to 0.87 m wide, 0.87 to 1.53 m high; wheelbase 1.2 to 1.65 m, uniform.

    Kinds: roadster (25 %), cruiser (20 %), sport with a fairing, tourer with screen and cases, scooter with a leg shield (15 %
    each), cross (10 %). Wheels: discs (20 %), 3 to 6 cast or 10 to 18 wire spokes; 1 or 2 cylinders, saddles, exhausts; mirrors
    (50 %).
    """
    kind = dice.pick(roadster=0.25, cruiser=0.2, sport=0.15, tourer=0.15, cross=0.1, scooter=0.15)
    small = kind == "scooter"
    radius = dice.between(0.2, 0.25) if small else dice.between(0.28, 0.35)
    base = dice.between(1.2, 1.35) if small else dice.between(1.3, 1.65)
    tyre, spokes = dice.between(0.09, 0.15), dice.pick(disc=0.2, cast=0.4, wire=0.4)
    count = {"disc": 0, "cast": dice.count(3, 6)}.get(spokes, dice.count(10, 18))
    front, rear = base / 2, -base / 2
    both_wheels = spoked(radius, tyre, count)
    parts = [part.at(x, z=radius) for x in (front, rear) for part in both_wheels]
    neck = (front - dice.between(0.25, 0.5) * (1.0 if kind == "cruiser" else 0.75), radius + dice.between(0.42, 0.55))
    parts += _fork(dice, front, radius, tyre, neck, kind=kind)
    parts += _scooter(dice, rear, front, radius, neck) if small else _frame(dice, rear, radius, tyre, neck, kind=kind)
    guard = _guard(radius + 0.03, 1.15 * tyre, 0.3, 2.3)
    parts.append(guard.at(rear, z=radius))
    if kind != "cross":
        parts.append(guard.at(front, z=radius))
    return parts


def _guard(radius: float, width: float, start: float, end: float) -> Part:
    """Return a mudguard: a strip bent around the wheel between two angles from +x."""
    angle = np.linspace(start, end, 9)
    path = np.column_stack([radius * np.cos(angle), np.zeros(9), radius * np.sin(angle)])
    return sweep(path, rectangle(width, 0.012), up=(1.0, 0.0, 0.0))


def _fork(dice: Dice, front: float, radius: float, tyre: float, neck: tuple[float, float], *, kind: str) -> Parts:
    """Return the fork, the handlebar, the light, and mirrors on half of them."""
    x, z = neck
    y = 0.75 * tyre
    top = z + 0.12
    slope = (x - front) / (z - radius)
    parts = both_sides([rod((front, y, radius), (x + slope * 0.12, y, top), 0.022)])
    parts.append(board(0.08, 2.6 * y, 0.05).at(x, z=z))
    wide, rise, back = dice.between(0.28, 0.42), {"cruiser": 0.25, "sport": -0.04}.get(kind, 0.1), dice.between(0.08, 0.25)
    hx = x + slope * 0.12
    bar = smooth([(hx - back, -wide, top + rise), (hx - 0.3 * back, -0.6 * wide, top + rise), (hx, -0.1, top), (hx, 0.1, top),
                  (hx - 0.3 * back, 0.6 * wide, top + rise), (hx - back, wide, top + rise)], 17)  # fmt: skip
    parts.append(sweep(bar, unit_circle(8) * 0.016))
    parts.append(ellipsoid(0.16, 0.18, 0.18).at(x + 0.14, z=z + 0.06))
    if dice.chance(0.5):
        stalk = rod((hx - 0.6 * back, 0.7 * wide, top + rise), (hx - 0.3 * back, 0.75 * wide, top + rise + 0.2), 0.007, sides=6)
        parts += both_sides([stalk, ellipsoid(0.03, 0.13, 0.09, 6, 10).at(hx - 0.3 * back, 0.75 * wide, top + rise + 0.22)])
    return parts


def _frame(dice: Dice, rear: float, radius: float, tyre: float, neck: tuple[float, float], *, kind: str) -> Parts:
    """Return frame, engine, tank, seat, exhausts, and what the kind adds."""
    nx, nz = neck
    seat = radius + (0.28 if kind == "cruiser" else dice.between(0.38, 0.5))
    low, y = 0.6 * radius + 0.05, 0.1
    middle = (rear + nx) / 2 + 0.05
    tube = rounded(
        [(nx, y, nz), (nx - 0.12, y, low), (middle - 0.2, y, low), (rear + 0.25, y, seat - 0.05), (nx, y, nz - 0.02)], 0.08
    )
    parts = both_sides(
        [sweep(tube, unit_circle(6) * 0.02), rod((rear, 0.7 * tyre + 0.03, radius), (middle - 0.2, 0.12, low + 0.1), 0.025)]
    )
    parts.append(board(0.36, 0.26, 0.24, 0.04).at(middle, z=low))
    for lean in (-0.4, 0.4) if dice.chance(0.5) else (dice.between(-0.5, 0.1),):
        parts.append(cylinder(0.085, 0.26, 14).turned(-lean, "y").at(middle - 0.2 * lean, z=low + 0.18))
    tank_length = dice.between(0.42, 0.56)
    parts.append(
        ellipsoid(tank_length, dice.between(0.26, 0.36), dice.between(0.22, 0.3), 8, 16).at(nx - tank_length / 2, z=nz - 0.02)
    )
    saddle = nx - tank_length + 0.1 - (rear - 0.1)
    for k in range(pads := dice.count(1, 2)):
        parts.append(
            cushion(1.06 * saddle / pads, 0.28, 0.11, 0.5).at(
                rear - 0.1 + (k + 0.5) * saddle / pads, z=seat - 0.03 + 0.05 * (pads - 1 - k)
            )
        )
    pipe = rounded(
        [(middle + 0.15, 0.17, low + 0.25), (middle + 0.2, 0.19, low), (rear + 0.2, 0.21, low), (rear - 0.2, 0.22, low + 0.12)],
        0.1,
    )
    exhaust = [
        sweep(pipe, unit_circle(8) * 0.03),
        rod((rear + 0.2, 0.21, low), (rear - 0.22, 0.22, low + 0.13), 0.045, 0.055, 12),
    ]
    parts += both_sides(exhaust) if dice.chance(0.4) else exhaust
    if kind == "sport":
        nose = [
            ellipsoid(0.6, 0.42, 0.55, 8, 16).turned(0.4, "y").at(nx + 0.1, z=nz - 0.02),
            tapered((0.3, 0.3), (0.12, 0.2), 0.3, (-0.2, 0)).at(nx + 0.12, z=nz + 0.15),
        ]
        parts += [*nose, ellipsoid(0.4, 0.2, 0.14).turned(0.3, "y").at(rear - 0.05, z=seat + 0.08)]
    if kind == "tourer":
        parts.append(board(0.02, 0.5, 0.45, 0.006).turned(-0.5, "y").at(nx + 0.2, z=nz + 0.1))
        parts += both_sides([board(0.45, 0.2, 0.32, 0.05).at(rear - 0.05, 0.28, radius + 0.1)])
        parts += [board(0.34, 0.4, 0.3, 0.06).at(rear - 0.2, z=seat + 0.03)] if dice.chance(0.6) else []
    return parts


def _scooter(dice: Dice, rear: float, front: float, radius: float, neck: tuple[float, float]) -> Parts:
    """Return leg shield, footboard, rear body and seat of a scooter."""
    nx, nz = neck
    deck = radius + 0.02
    shield = sweep(
        rounded([(nx - 0.25, 0, deck), (nx - 0.1, 0, deck), (nx + 0.02, 0, nz + 0.1)], 0.08),
        superellipse(0.42, 0.05, 3.0, 16),
        up=(0, 0, 1),
    )
    body = cushion(0.85, 0.38, 0.38, 0.6).at(rear + 0.05, z=radius + 0.04)
    seat = cushion(0.72, 0.3, 0.12, 0.5).at(rear + 0.08, z=radius + 0.38)
    parts = [shield, body, seat, board(nx - rear - 0.2, 0.34, 0.07).at((nx + rear) / 2, z=deck - 0.04)]
    parts.append(rod((front, 0.0, radius), (nx, 0.0, nz + 0.05), 0.035))
    if dice.chance(0.5):
        parts.append(board(0.3, 0.32, 0.26, 0.06).at(rear - 0.35, z=radius + 0.4))
    if dice.chance(0.4):
        parts.append(board(0.02, 0.4, 0.4, 0.006).turned(-0.3, "y").at(nx + 0.08, z=nz + 0.15))
    return parts

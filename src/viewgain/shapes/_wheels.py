"""Wheels: axle along y, centred on the origin."""

from math import pi

from viewgain.shapes._assemble import Parts, both_sides
from viewgain.shapes._lathe import lathe
from viewgain.shapes._part import Part
from viewgain.shapes._primitives import cylinder, torus
from viewgain.shapes._sweep import rod


def wheel(radius: float, width: float, sides: int = 18) -> Part:
    """Return a car's wheel: a tyre with rounded shoulders and a sunken hub."""
    half = width / 2
    left = [
        (0.2 * radius, -0.45 * half),
        (0.58 * radius, -0.5 * half),
        (0.66 * radius, -half),
        (0.9 * radius, -half),
        (radius, -0.6 * half),
    ]
    return lathe(left + [(r, -y) for r, y in left[::-1]], sides).turned(pi / 2, "x")


def axles(places: list[float], track: float, radius: float, width: float) -> Parts:
    """Return a pair of wheels at each x, standing on z = 0, their outer faces ``track`` apart."""
    one = wheel(radius, width)
    return both_sides([one.at(x, (track - width) / 2, radius) for x in places])


def spoked(radius: float, tyre: float, spokes: int) -> Parts:
    """Return a motorbike's wheel: a round tyre, a hub and spokes; no spokes gives a solid disc."""
    hub_radius, hub_width = 0.16 * radius, 1.3 * tyre
    hub = cylinder(hub_radius, hub_width, 12).turned(pi / 2, "x").at(y=hub_width / 2)
    ring = torus(radius - tyre / 2, tyre, 24, 8).turned(pi / 2, "x")
    if spokes == 0:
        thick = 0.35 * tyre
        return [ring, hub, cylinder(radius - 0.8 * tyre, thick, 24).turned(pi / 2, "x").at(y=thick / 2)]
    spoke = rod((0.0, 0.0, 0.0), (0.0, 0.0, radius - 0.7 * tyre), 0.14 * tyre, sides=6)
    return [ring, hub, *(spoke.turned(2 * pi * k / spokes, "y") for k in range(spokes))]

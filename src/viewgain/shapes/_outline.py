"""Closed outlines in the plane: (n, 2), counter-clockwise, star-shaped about the origin."""

from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Points2, Vector


@lru_cache(maxsize=128)
def unit_circle(sides: int) -> Points2:
    """Return a regular polygon inscribed in the unit circle; its first corner is (1, 0). Shared: never write to it."""
    angle = np.arange(sides) * (2 * np.pi / sides)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    circle.flags.writeable = False
    return circle


def ellipse(x: float, y: float, sides: int = 24) -> Points2:
    """Return an ellipse of the given full widths."""
    return np.asarray(unit_circle(sides) * (x / 2, y / 2))


def rectangle(x: float, y: float, radius: float = 0.0, steps: int = 3) -> Points2:
    """Return a rectangle of the given full widths; corners of a positive radius are rounded, in ``steps`` chords each."""
    signs = _QUADRANTS
    if radius <= 0:
        return np.asarray(signs * (x / 2, y / 2))
    radius = min(radius, 0.499 * x, 0.499 * y)
    centres = signs * (x / 2 - radius, y / 2 - radius)
    return np.asarray((centres[:, None] + radius * _quarters(steps)).reshape(-1, 2))


def superellipse(x: float, y: float, power: float, sides: int = 24) -> Points2:
    """Return |2u/x|^power + |2v/y|^power = 1: an ellipse for 2, squarer above."""
    circle = unit_circle(sides)
    return np.asarray(np.sign(circle) * np.abs(circle) ** (2 / power) * (x / 2, y / 2))


def polar(radii: Vector) -> Points2:
    """Return the outline that lies at these distances from the origin, at equal steps of angle."""
    return np.asarray(unit_circle(len(radii)) * np.asarray(radii)[:, None])


_QUADRANTS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


@lru_cache(maxsize=16)
def _quarters(steps: int) -> Array:
    """Return (4, steps + 1, 2) unit quarter circles, one for each corner of a rectangle."""
    angle = np.linspace(0, np.pi / 2, steps + 1) + np.arange(4)[:, None] * (np.pi / 2)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

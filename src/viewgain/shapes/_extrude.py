"""Extrusion: an outline pulled straight up, its edges bevelled if wanted."""

import numpy as np

from viewgain.arrays import Points2
from viewgain.shapes._part import Part, skin


def extrude(outline: Points2, height: float, *, bevel: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)) -> Part:
    """Return the prism over an outline, from z = 0 to ``height``.

    Args:
        outline: (n, 2) counter-clockwise polygon, star-shaped about ``centre``.
        height: Metres.
        bevel: How far the top and bottom edges are cut back, metres; less than half of any width.
        centre: Where the top and bottom fans meet.
    """
    rings = np.empty((4 if bevel > 0 else 2, len(outline), 3))
    rings[:, :, :2] = outline
    if bevel > 0:
        reach = np.abs(outline - centre).max(axis=0)
        rings[[0, 3], :, :2] = (outline - centre) * (1 - bevel / reach) + centre
        rings[:, :, 2] = [[0.0], [bevel], [height - bevel], [height]]
    else:
        rings[:, :, 2] = [[0.0], [height]]
    return skin(rings, np.array([*centre, 0.0]), np.array([*centre, height]))


def side_profile(outline: Points2, width: float, *, bevel: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)) -> Part:
    """Return an outline given in (x, z) as a solid of that width along y, symmetric about y = 0."""
    return extrude(outline, width, bevel=bevel, centre=centre).turned(np.pi / 2, "x").at(y=width / 2)


def front_profile(outline: Points2, depth: float, *, bevel: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)) -> Part:
    """Return an outline given in (y, z) as a solid of that depth along x, from x = 0 forwards."""
    part = extrude(outline, depth, bevel=bevel, centre=centre)
    return Part(part.vertices[:, [2, 0, 1]], part.faces)

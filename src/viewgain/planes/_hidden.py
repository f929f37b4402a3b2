"""Sides that nothing comes back from (a mend of ours): they stand where the line of the two other faces ends."""

from dataclasses import replace

import numpy as np

from viewgain.planes._cloud import Cloud
from viewgain.planes._lines import line_segments
from viewgain.planes._parallel import Planes
from viewgain.planes._settings import Settings


def with_hidden_sides(planes: Planes, cloud: Cloud, settings: Settings) -> Planes:
    """Return the planes; with two hidden ones if they have two directions only.

    A side seen under more than 70 degrees loses its returns, or is a row of pixels. But the faces next to it end on it: the line
    on which they meet begins and ends in planes at right angles to it. The line with the most points is taken.

    Args:
        planes: The planes found.
        cloud: The points.
        settings: As for :func:`line_segments`.
    """
    if len(planes.normals) != 2:
        return planes
    segments = line_segments(planes, cloud, settings)
    if len(segments) == 0:
        return planes
    best = int(np.argmax(segments.support))
    across = segments.directions[best]
    return replace(
        planes,
        normals=np.concatenate([planes.normals, across[None]]),
        direction=np.append(planes.direction, [2, 2]),
        offsets=np.append(planes.offsets, -segments.ends[best] @ across),
        hidden=2,
    )

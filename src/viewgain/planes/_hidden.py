"""Sides that nothing comes back from (a mend of ours): they stand where the line of the two other faces ends."""

from dataclasses import replace

import numpy as np

from viewgain.planes._lines import Segments
from viewgain.planes._parallel import Planes


def with_hidden_sides(planes: Planes, segments: Segments) -> Planes:
    """Return the planes of the two directions whose line has the most points, and two hidden ones across them.

    A side seen under more than 70 degrees loses its returns, or is a row of pixels. But the faces next to it end on it: the line
    on which they meet begins and ends in planes at right angles to it.

    Args:
        planes: The planes found; those along other directions made no corner and go.
        segments: The lines on which they meet, at least one.
    """
    best = int(np.argmax(segments.support))
    across = segments.directions[best]
    own = planes.kept(np.isin(planes.direction, planes.direction[segments.planes[best]]))
    return replace(
        own,
        normals=np.concatenate([own.normals, across[None]]),
        direction=np.append(own.direction, [2, 2]),
        offsets=np.append(own.offsets, -segments.ends[best] @ across),
        hidden=2,
    )

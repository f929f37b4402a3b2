"""Wings and fins: a lens-shaped section that gets smaller, moves back and rises along the span."""

import numpy as np

from viewgain.shapes._part import Part, skin


def wing(root: float, tip: float, span: float, *, sweep: float = 0.0, rise: float = 0.0, thickness: float = 0.12) -> Part:
    """Return one wing along +y, from y = 0, leading edge towards +x.

    Args:
        root: Chord at y = 0, centred on x = 0, metres.
        tip: Chord at the end.
        span: Length along y.
        sweep: How far the middle of the tip lies behind that of the root.
        rise: How far the tip lies above the root.
        thickness: Thickness as a share of the chord.
    """
    angle = np.arange(14) * (2 * np.pi / 14)
    section = np.column_stack([np.sin(angle) / 2, thickness / 2 * np.cos(angle) * (1 + 0.5 * np.sin(angle))])
    place = np.array([0.0, 0.25, 0.5, 0.75, 0.96, 1.0])
    chord = (root + (tip - root) * place) * [1, 1, 1, 1, 1, 0.8]
    rings = np.empty((len(place), len(angle), 3))
    rings[:, :, 0] = chord[:, None] * section[:, 0] - sweep * place[:, None]
    rings[:, :, 1] = span * place[:, None]
    rings[:, :, 2] = chord[:, None] * section[:, 1] + rise * place[:, None]
    return skin(rings)

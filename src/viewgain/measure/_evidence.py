"""What speaks against a box in the pixels of a fitted one: relief on its faces, holes in it, no free edge; and flaps beside it.

A box is fitted to anything. On a thing that is none the residuals of the faces keep a shape after averaging, the corners of the
outline see the floor, and a wall goes on where the box should end (ours; thresholds: docs/shapes.md).
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask
from viewgain.box import Box, floor_hits
from viewgain.measure._likelihood import Evaluation
from viewgain.measure._mixture import Pixels

MAX_RELIEF = (0.0023, 0.0138)
"""Largest relief of a box's faces: metres, and a share of its size. Cartons measured so far stay under half of it."""
MAX_BULGE = 0.045
"""Deepest bend of a face, as a share of its shorter side."""
MAX_HOLES = 0.25
"""Largest share of the returns inside the outline that lie behind the box."""
MAX_PROUD = 0.13
"""Largest share of them that lie before it."""
BULGE_WEIGHT = 0.08
"""Relief, holes and bend count together, as a root of squares over their limits; the bend over this, since cartons do bulge."""
MIN_FREE_EDGE = 0.04
"""Beside at least this share of the outline within the image the camera must see something farther away, or nothing."""
MAX_SLENDER = 6.0
"""What stands upright more than this many times as high as it is wide either way is a leg or a post."""
MIN_FLAPS = 0.03
"""Flaps are flagged from this share of the returns on the box."""
_BLOCK_PX = 6.0
_MIN_BLOCK = 6
_BAND_PX = (2.0, 6.0)
_FLAP_FROM = 0.6
_FLAP_REACH = 0.6


@dataclass(frozen=True, slots=True)
class Evidence:
    """What the pixels say against a fitted box."""

    relief: float = 0.0
    """Root mean square of the faces' residuals along their normals, means over 6 x 6 pixels less their noise, metres."""
    holes: float = 0.0
    """Share of the returns inside the outline that lie behind the box."""
    proud: float = 0.0
    """Share of them that lie before it."""
    free_edge: float = 1.0
    """Share of the pixels just outside the outline that see something farther than the box, or nothing."""
    bulge: float = 0.0
    """Deepest bend of a face over its shorter side."""
    slender: bool = False
    """Whether it stands upright like a leg or a post."""
    sliver: bool = False
    """Whether it is a small thing without thickness."""
    flaps: float = 0.0
    """Returns beside the upper part of the box with nothing beneath them, over the returns on the box."""

    def against(self, size: float) -> bool:
        """Return whether this is no box, given the cube root of its volume, metres."""
        relief = self.relief / (MAX_RELIEF[0] + MAX_RELIEF[1] * size)
        together = float(np.linalg.norm([relief, self.holes / MAX_HOLES, self.bulge / BULGE_WEIGHT]))
        return together > 1 or self.bulge > MAX_BULGE or self.proud > MAX_PROUD or self.slender or self.sliver

    @property
    def endless(self) -> bool:
        """Whether nothing shows that the box ends anywhere: a wall, or the middle of something large."""
        return self.free_edge < MIN_FREE_EDGE


NOTHING_AGAINST = Evidence()
"""A flawless box."""


def tolerance(ranges: Array, sigma: Array) -> Array:
    """Return the (n,) deviation up to which a range agrees with a face: 5 mm, 0.4 % and four sigma, metres."""
    return np.asarray(0.005 + 0.004 * ranges + 4 * sigma)


def relief(evaluation: Evaluation, pixels: Pixels, on_face: Mask, sigma: Array) -> float:
    """Return the root mean square relief of the faces, metres; 0 where noise explains it or there is little to tell."""
    used = np.flatnonzero(on_face)
    if len(used) == 0:
        return 0.0
    hits = evaluation.hits
    height = (pixels.ranges[used] - hits.ranges[used]) * hits.cosine[used]
    cell = np.floor(pixels.image[used] / (pixels.pitch * _BLOCK_PX)).astype(int)
    cell -= cell.min(axis=0)
    key = (cell[:, 1] * (cell[:, 0].max() + 1) + cell[:, 0]) * 8 + hits.planes[used]
    _, block, count = np.unique(key, return_inverse=True, return_counts=True)
    mean = np.bincount(block, height) / count
    noise = np.square(np.bincount(block, sigma[used] * hits.cosine[used]) / count) / count
    full = count >= _MIN_BLOCK
    return float(np.sqrt(max(float(np.mean(mean[full] ** 2 - noise[full])), 0.0))) if full.any() else 0.0


def holes(evaluation: Evaluation, pixels: Pixels, sigma: Array) -> tuple[float, float]:
    """Return the shares of the returns well inside the outline that lie behind the box, and before it."""
    deep = (evaluation.inside > 2) & np.isfinite(pixels.ranges) & ~pixels.other
    off, allowed = pixels.ranges - evaluation.hits.ranges, tolerance(pixels.ranges, sigma)
    behind, before = (float(pixels.weight[deep & part].sum()) for part in (off > allowed, off < -allowed))
    total = max(float(pixels.weight[deep].sum()), 1.0)
    return behind / total, before / total


def free_edge(evaluation: Evaluation, pixels: Pixels, sigma: Array) -> float:
    """Return the share of the pixels two to six outside the outline that see something farther than the box, or nothing.

    Another object farther away is something farther: it too shows that the box ends.
    """
    band = (evaluation.inside < -_BAND_PX[0]) & (evaluation.inside > -_BAND_PX[1])
    ranges = evaluation.hits.ranges
    reach = np.maximum(tolerance(ranges, sigma), 0.02)
    farther = band & (np.isnan(pixels.ranges) | (pixels.ranges > ranges + reach))
    return float(pixels.weight[farther].sum() / max(pixels.weight[band].sum(), 1.0))


def flaps(box: Box, pixels: Pixels, on_box: float, sigma: Array) -> float:
    """Return how many returns float beside the upper part of the box, or over it, over the ``on_box`` returns on its faces.

    What hangs there with as much beneath it is a neighbour, not a flap: zero.
    """
    returned = np.isfinite(pixels.ranges) & (pixels.ranges < 0.99 * floor_hits(box, pixels.directions).ranges)
    points = pixels.directions * np.where(returned, pixels.ranges, 0.0)[:, None]
    local = (points - box.box_to_camera[:3, 3]) @ box.box_to_camera[:3, :3]
    margin = 0.01 + 3 * sigma
    over = np.maximum(np.abs(local) - box.extents / 2, 0.0)
    over[:, 2] = np.maximum(local[:, 2] - box.extents[2], 0.0)
    away = np.linalg.norm(over, axis=1)
    beside = returned & (away > margin) & (away < _FLAP_REACH * box.extents.max())
    high = local[:, 2] > _FLAP_FROM * box.extents[2]
    above, beneath = (pixels.weight[beside & part & (local[:, 2] > 0.02)].sum() for part in (high, ~high))
    return float(above / max(on_box, 1.0)) if above > 3 * beneath else 0.0

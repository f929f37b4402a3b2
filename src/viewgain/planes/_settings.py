"""Every parameter of the plane-and-line method, with the published values, and one switch per mend.

A mend repairs one thing that the published program does and that costs accuracy (docs/lines.md names each and what it buys). All
of them off is :data:`AS_PUBLISHED`, all of them on :data:`MENDED`.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from viewgain.errors import ConfigError

Method = Literal["lines", "corners"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Parameters and switches; lengths in metres, angles in radians. The defaults are the published ones."""

    name: str = "published"
    """What to call these settings in results."""
    method: Method = "lines"
    """``lines``: a dimension is the length of a segment. ``corners``: it runs from the three planes' common point to the
    segment's far end, and between two parallel planes where both are seen."""
    seed: int = 0
    """Of the draw of references and pairs, where no generator is given: the same scan gives the same answer."""

    region: float | None = 0.75
    """Radius of the ball about the middle of the image that is looked at (as the reference was run); None: all."""
    image_width: int = 224
    """Images 1.5 times as wide or more are averaged over blocks to about this width (VGA: 3 x 3), as the reference was run."""
    normal_radius: float = 0.035
    """Ball of the principal component analysis that gives a point its normal (the reference was run with 3.5 and 2.5 cm)."""

    pair_max: float = 1.0
    """dmax: a voting pair is nearer than this."""
    pair_min: float = 0.1
    """dmin: and farther than this."""
    min_votes: int = 5
    """Support a reference and a cell of its table need."""
    references: int = 500
    """References drawn with replacement; n / 500 if that is more."""
    pairs: int = 250
    """At most so many partners per reference."""
    angle_bins: int = 36
    """Cells of the table around the reference's normal."""
    offset_bins: int = 12
    """Cells of the table on either side of zero offset."""
    angle_tolerance: float = float(np.pi / 18)
    """Two planes within this of 90 degrees are orthogonal, within this of 0 parallel."""
    normal_gate: float = float(np.pi / 9)
    """A point belongs to a plane if its normal is within this of the plane's."""
    final_gate: float = float(np.pi / 9)
    """The same in the second refinement and the last filter."""
    crossing: float = float(np.sin(np.pi / 9))
    """Two planes whose cosine is under this meet in a line."""
    band: float = 1.0 / 12.0
    """tau_d: distance at which two planes are one, and at which a point belongs to a plane or to a line."""
    line_band: float = 1.0 / 12.0
    """Distance from a line within which points tell where its segment ends."""
    corner_radius: float = 0.12
    """Points this near to where three planes meet refine the corner."""
    stride: int = 10
    """Every so-many-th point in the refinement, twice as many in the filter and for the lines."""
    orthogonality: float = 0.01
    """lambda per point: how much the squared cosine between two orthogonal planes weighs against squared distances."""
    min_inliers: int = 1
    """Points a plane needs to stay, counting each of the filter's for as many as it stands for."""
    max_directions: int | None = None
    """Keep the directions with the most points; None: all."""
    merge_band: float = 1.0 / 12.0
    """Distance at which parallel planes are one after the refinement."""
    min_length: float = 0.05
    """Shorter segments are no edges of a box."""
    max_gap: float = 0.10
    """The mean distance between the near ends of a triplet must be under this (our reading of "close to each other")."""
    right_angle: float = 0.26
    """Largest cosine between two segments of a triplet (our reading)."""
    partner_reach: float = 0.10
    """``corners``: the distance to a parallel plane replaces a length that is within this of it."""

    block_normals: bool = False
    """Mend: in an image, normals come from balls around the means of blocks of pixels. Published: around every point."""
    unbiased_decode: bool = False
    """Mend: a cell stands for the mean of what voted into it. Published: for a point half a cell off its centre."""
    random_pairs: bool = False
    """Mend: partners drawn at random. Published: the first ones of a tree, which lie in a clump about the reference."""
    balanced_draw: bool = False
    """Mend: references and partners drawn evenly over the directions of normals, so that the floor does not take them all."""
    peaks_only: bool = False
    """Mend: of neighbouring cells only the highest counts. Published: each cell over the threshold is a plane."""
    signed_merge: bool = False
    """Mend: an offset changes its sign with its normal when directions are united. Published: not after the refinement."""
    forward_only: bool = False
    """Mend: a segment whose two planes do not overlap along the line is none. Published: it counts with its length reversed."""
    complete: bool = False
    """Mend: faces along the box's three directions that won no votes are added where points agree on an offset."""
    hidden_sides: bool = False
    """Mend: where three planes make no corner, the sides that are not seen are where the line of two seen ones ends."""
    by_support: bool = False
    """Mend: of the triplets within ``max_gap`` the one with the most points wins. Published (in our reading): the least gap."""
    convex_only: bool = False
    """Mend: two planes meet in an edge of a box only if each one's points lie behind the other, as the camera sees it."""
    true_corners: bool = False
    """Mend: a triplet's three segments are those of three planes. Published: any three segments will do."""
    soft_ends: bool = False
    """Mend: points belong to a plane by distance and a segment ends where their density halves. Published: by normal, at the
    last point; normals turn within one radius of an edge, which shortens every segment by about that radius."""

    refine_corner: bool = False
    """Mend of ``corners``: the corner is fitted to the points around it with exact right angles. Published: where the three
    planes meet."""

    def __post_init__(self) -> None:
        if self.method not in ("lines", "corners"):
            raise ConfigError(f"method: got {self.method!r}, wanted 'lines' or 'corners'")
        positive = ("normal_radius", "pair_max", "band", "merge_band", "references", "pairs", "stride", "image_width")
        for name in positive:
            if not getattr(self, name) > 0:
                raise ConfigError(f"{name}: got {getattr(self, name)}, wanted a number over 0")
        if not 0 <= self.pair_min < self.pair_max:
            raise ConfigError(f"pair_min: got {self.pair_min}, wanted 0 to pair_max = {self.pair_max}")

    @property
    def offset_width(self) -> float:
        """Width of a cell of the table in offset, metres."""
        return self.pair_max / self.offset_bins

    @property
    def right(self) -> float:
        """Largest cosine of two planes that are orthogonal."""
        return float(np.sin(self.angle_tolerance))

    @property
    def parallel(self) -> float:
        """Smallest cosine of two planes that are parallel."""
        return float(np.cos(self.angle_tolerance))

    @property
    def gate(self) -> float:
        """Smallest cosine between a point's normal and that of its plane."""
        return float(np.cos(self.normal_gate))

    def at_last(self) -> "Settings":
        """Return the settings of the second refinement and the last filter."""
        return replace(self, normal_gate=self.final_gate)

    def using(self, method: Method) -> "Settings":
        """Return the same settings for the other way to read off dimensions."""
        return replace(self, method=method)


AS_PUBLISHED = Settings()
"""The public program of Sommer et al., with the lines it leaves switched off."""

MENDED = Settings(
    name="mended",
    normal_radius=0.04,
    references=160,
    pairs=400,
    band=0.04,
    merge_band=0.03,
    partner_reach=0.03,
    offset_bins=24,
    min_inliers=30,
    final_gate=float(np.pi / 2),
    stride=4,
    max_directions=8,
    block_normals=True,
    unbiased_decode=True,
    random_pairs=True,
    balanced_draw=True,
    peaks_only=True,
    signed_merge=True,
    forward_only=True,
    complete=True,
    hidden_sides=True,
    by_support=True,
    convex_only=True,
    true_corners=True,
    soft_ends=True,
    refine_corner=True,
)
"""The same method with every mend on."""

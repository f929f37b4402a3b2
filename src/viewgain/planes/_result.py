"""What measuring by lines returns: dimensions or a reason, with the planes and segments behind them."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Points, Vector, Vector3

SCHEMA = 1
"""Version of the JSON form; it grows by new keys only."""
REASONS = {
    "too_few_points": "too few points with normals in the middle of the image; is the box there, and in range?",
    "no_planes": "no two orthogonal planes found; show the box's faces at an angle, not one of them head-on",
    "no_lines": "planes found, but no two of them meet where both have points",
    "no_triplet": "no three edges at right angles close to each other; turn towards an edge of the box so that two sides show",
}
"""Why there are no dimensions, and what to do about it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LineMeasurement:
    """The box that planes and lines give, or the reason why they give none. The method states no error bars."""

    source: str
    """Where the scan came from."""
    method: str
    """``lines`` or ``corners``."""
    settings: str
    """Name of the settings."""
    normals: Points
    """(m, 3) unit normals of the planes found, camera frame."""
    offsets: Vector
    """(m,) their offsets: normal . x + offset = 0, metres."""
    segments: Array
    """(s, 2, 3) end points of the lines found, metres, camera frame."""
    edges: Array
    """(3, 2, 3) the three segments that were chosen, near ends first; empty if there is a reason."""
    corner: Vector3 | None
    """(3,) the box's corner, metres, camera frame."""
    dimensions: Vector3 | None
    """(3,) length >= width >= height by size, metres."""
    reason: str | None
    """A key of :data:`REASONS`, or None."""

    @property
    def volume(self) -> float | None:
        """Product of the dimensions, cubic metres."""
        return None if self.dimensions is None else float(np.prod(self.dimensions))

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/lines.md); spreads are null, for the method has none."""
        found = self.dimensions is not None
        return {
            "schema": SCHEMA,
            "scans": [self.source],
            "method": self.method,
            "settings": self.settings,
            "planes": len(self.offsets),
            "segments": len(self.segments),
            "dimensions_m": _rounded(self.dimensions),
            "sigma_m": [None, None, None] if found else None,
            "volume_m3": None if self.volume is None else round(self.volume, 6),
            "volume_sigma_m3": None,
            "corner_camera_m": _rounded(self.corner),
            "edges_camera_m": _rounded(self.edges),
            "reason": self.reason,
        }


def _rounded(array: Array | None) -> list[object] | None:
    return None if array is None else np.round(array, 6).tolist()

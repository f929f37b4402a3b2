"""What every view covers of a surface: worked out once per model, and the labels of any start and number of steps follow."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Ids, Mask, Points, Vector
from viewgain.errors import ConfigError, ScanError
from viewgain.gain._bits import Bits, packed, size, unpacked
from viewgain.gain._near import Pairs, Search, Starts, near_pairs


@dataclass(frozen=True, slots=True, eq=False)
class Cover:
    """The clouds of V views and the surface samples that each of their points covers."""

    points: Points
    """(n, 3) points of all clouds, view after view."""
    view_starts: Starts
    """(V + 1,) where each view's points start."""
    pairs: Pairs
    """For each point, the surface samples it covers."""
    masks: Bits
    """(V, w) the surface samples that each view covers, bit-packed (:func:`viewgain.gain.unpacked`)."""
    surface_count: int
    """Number of surface samples, m."""
    reach: float
    """Points nearer than this cover a sample."""
    search: Search
    """How near points are found."""

    @property
    def views(self) -> int:
        """How many views there are, V."""
        return len(self.masks)

    @property
    def view_of_point(self) -> Ids:
        """(n,) the view that each point belongs to."""
        return np.repeat(np.arange(self.views, dtype=np.int32), np.diff(self.view_starts))

    @property
    def coverage(self) -> Vector:
        """(V,) share of the surface that each view covers alone, 0 to 1."""
        return size(self.masks) / self.surface_count

    def mask(self, view: int) -> Mask:
        """Return the (m,) mask of the samples that a view covers."""
        return unpacked(self.masks[view], self.surface_count)


def cover(clouds: Sequence[Points], surface: Points, reach: float, *, search: Search = "auto") -> Cover:
    """Return which surface samples every point of every view covers: those nearer than ``reach`` (strictly, squares compared).

    Args:
        clouds: One (n, 3) cloud per view, same frame and unit as the surface; n may be 0.
        surface: (m, 3) samples of the true surface, m >= 1.
        reach: How near is near, > 0. Memory goes with the number of near pairs, a few per point at the published reach.
        search: How near points are found; all ways give the same masks, bit for bit.

    Raises:
        ScanError: If there is no cloud or no surface, or their points are not finite (n, 3).
        ConfigError: If the reach is not a positive number.
        MissingExtraError: If "numba" was asked for and is not installed.

    Source:
        Zeng et al. (2020), PC-NBV: distance to the nearest point, squared, below 0.00005.
    """
    if not (np.isfinite(reach) and reach > 0):
        raise ConfigError(f"cover: got a reach of {reach}, wanted a positive number")
    if not len(clouds) or not len(surface):
        raise ScanError(f"cover: got {len(clouds)} clouds and {len(surface)} surface points, wanted at least one of each")
    for name, cloud in [*((f"cloud {view}", cloud) for view, cloud in enumerate(clouds)), ("surface", surface)]:
        if np.ndim(cloud) != 2 or np.shape(cloud)[1] != 3 or not np.all(np.isfinite(cloud)):
            raise ScanError(f"cover: {name} has the shape {np.shape(cloud)} or is not finite, wanted finite (n, 3) points")
    points = np.ascontiguousarray(np.concatenate(clouds), dtype=float)
    starts = np.concatenate([[0], np.cumsum([len(cloud) for cloud in clouds])]).astype(np.int64)
    pairs = near_pairs(points, np.ascontiguousarray(surface, dtype=float), reach, search=search)
    covered = np.zeros((len(clouds), len(surface)), dtype=bool)
    for view, (start, end) in enumerate(zip(pairs.starts[starts[:-1]], pairs.starts[starts[1:]], strict=True)):
        covered[view, pairs.ids[start:end]] = True
    return Cover(points, starts, pairs, packed(covered), len(surface), reach, search)

"""What every view covers of a surface: worked out once per model, and the labels of any start and number of steps follow."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Ids, Mask, Points, Vector
from viewgain.errors import ConfigError, ScanError
from viewgain.gain._bits import Bits, packed, size, unpacked
from viewgain.gain._near import near_pairs
from viewgain.gain._pairs import Pairs, Starts, Tally, tally
from viewgain.gain._search import Search


@dataclass(frozen=True, slots=True, eq=False)
class Cover:
    """The clouds of V views and the surface samples that each of their points covers."""

    points: Points
    """(n, 3) points of all clouds, view after view."""
    view_starts: Starts
    """(V + 1,) where each view's points start."""
    pairs: Pairs
    """For each point, the surface samples it covers."""
    counts: Tally
    """(V, m) how many points of each view cover each sample."""
    masks: Bits
    """(V, w) the surface samples that each view covers, bit-packed (:func:`viewgain.gain.unpacked`)."""
    reach: float
    """Points nearer than this cover a sample."""
    search: Search
    """How near points are found."""

    @property
    def views(self) -> int:
        """How many views there are, V."""
        return len(self.masks)

    @property
    def surface_count(self) -> int:
        """Number of surface samples, m."""
        return int(self.counts.shape[1])

    @property
    def view_of_point(self) -> Ids:
        """(n,) the view that each point belongs to."""
        return _view_of_point(self.view_starts)

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
    counts = np.zeros((len(clouds), len(surface)), dtype=np.int32)
    tally(counts, pairs, np.arange(len(points)), _view_of_point(starts), 1, search=search)
    return Cover(points, starts, pairs, counts, packed(counts > 0), reach, search)


def _view_of_point(view_starts: Starts) -> Ids:
    return np.repeat(np.arange(len(view_starts) - 1, dtype=np.int32), np.diff(view_starts))

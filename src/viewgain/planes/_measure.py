"""From one scan to a box by orthogonal planes, lines and corners: the whole method, one step per line.

Sommer et al. (RA-L 2020), which the source paper takes volumes from; docs/lines.md describes it in our words.
"""

import numpy as np

from viewgain.planes._cloud import Cloud, cloud_of
from viewgain.planes._cluster import cluster
from viewgain.planes._complete import completed
from viewgain.planes._hidden import with_hidden_sides
from viewgain.planes._lines import Segments, line_segments
from viewgain.planes._parallel import Planes, merged, parallel_sets, united_triangles
from viewgain.planes._refine import filtered, refined
from viewgain.planes._result import LineMeasurement
from viewgain.planes._settings import MENDED, Settings
from viewgain.planes._triplet import Triplet, best_triplet
from viewgain.planes._votes import vote
from viewgain.scans import Scan

_FEWEST_POINTS = 50
_FINAL_STRIDE = 2.5
"""The second refinement takes so many times fewer points than the first, as published."""


def measure_lines(scan: Scan, settings: Settings = MENDED, *, rng: np.random.Generator | None = None) -> LineMeasurement:
    """Measure the box in the middle of a scan by its planes and the lines on which they meet.

    Args:
        scan: The scan, camera frame; its normals are used if it has any.
        settings: Parameters, method and mends; :data:`AS_PUBLISHED`, :data:`MENDED` or your own.
        rng: Draws references and pairs; by default seeded by the settings, so that the same scan gives the same answer.

    Returns:
        Dimensions, corner and edges, or a reason; planes and segments either way.
    """
    cloud = cloud_of(scan, settings)
    planes = find_planes(cloud, settings, rng=np.random.default_rng(settings.seed) if rng is None else rng)
    segments = line_segments(planes, cloud, settings)
    triplet = best_triplet(segments, planes, cloud, settings)
    if triplet is None and settings.hidden_sides and len(segments):
        planes = with_hidden_sides(planes, segments)
        segments = line_segments(planes, cloud, settings)
        triplet = best_triplet(segments, planes, cloud, settings)
    return _result(scan, settings, cloud, planes, segments, triplet)


def find_planes(cloud: Cloud, settings: Settings, *, rng: np.random.Generator) -> Planes:
    """Return the planes of a cloud: voted for, clustered, grouped, filtered and fitted together."""
    voted = vote(cloud, settings, rng)
    distinct = cluster(voted, settings)
    planes = united_triangles(parallel_sets(distinct, settings))
    planes = filtered(planes, cloud, settings)
    planes = refined(planes, cloud.every(settings.stride), settings)
    planes = merged(planes, settings)
    if settings.complete:
        planes = completed(planes, cloud, settings)
    planes = refined(planes, cloud.every(round(_FINAL_STRIDE * settings.stride)), settings.at_last())
    return filtered(planes, cloud, settings.at_last())


def _result(
    scan: Scan, settings: Settings, cloud: Cloud, planes: Planes, segments: Segments, triplet: Triplet | None
) -> LineMeasurement:
    edges, corner, dimensions = np.empty((0, 2, 3)), None, None
    if triplet is not None:
        ends = segments.ends[triplet.segments]
        edges = np.take_along_axis(ends, np.stack([triplet.near, 1 - triplet.near], axis=1)[..., None], axis=1)
        corner, dimensions = triplet.corner, -np.sort(-triplet.lengths)
    return LineMeasurement(
        source=scan.source,
        method=settings.method,
        settings=settings.name,
        normals=planes.each_normal,
        offsets=planes.offsets,
        segments=segments.ends,
        edges=edges,
        corner=corner,
        dimensions=dimensions,
        reason=_reason(cloud, planes, segments, triplet),
    )


def _reason(cloud: Cloud, planes: Planes, segments: Segments, triplet: Triplet | None) -> str | None:
    if triplet is not None:
        return None
    if len(cloud) < _FEWEST_POINTS:
        return "too_few_points"
    if len(planes.normals) < 2:
        return "no_planes"
    return "no_lines" if len(segments) == 0 else "no_triplet"

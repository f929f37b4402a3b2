"""A depth camera looks at boxes on a floor: true ranges by the slab test, then the sensor's noise and losses."""

import numpy as np
from scipy import ndimage

from viewgain.arrays import Array, Image, Points, Pose
from viewgain.box import Box, box_hits, entry_mask
from viewgain.camera import Intrinsics, Sensor
from viewgain.geometry import inverse
from viewgain.scans import Scan
from viewgain.simulate._scene import Scene

EDGE_JUMP = 0.03
"""Neighbouring ranges that differ by more are a depth edge, metres."""


def capture(
    scene: Scene, camera_to_world: Pose, sensor: Sensor, *, rng: np.random.Generator | None, source: str = "simulated"
) -> Scan:
    """Return one scan of ``scene``.

    Every pixel looks in a slightly wrong direction (lateral noise) but reports its nominal one; its range gets noise that grows
    with range and incidence; pixels on a depth edge may mix foreground and background; grazing and far returns are lost. The
    calibration error is not drawn here: see :func:`miscalibrated`.

    Args:
        scene: Boxes on the world's floor.
        camera_to_world: (4, 4) pose of the camera.
        sensor: The camera.
        rng: Source of all randomness; None for a perfect camera.
        source: Name of the scan.

    Returns:
        An organised scan with the camera's intrinsics and pose.

    Raises:
        ScanError: If fewer than 100 pixels return anything.
    """
    camera = sensor.intrinsics
    directions = pixel_directions(camera, 0.0 if rng is None else sensor.lateral_px, rng)
    ranges, cosine = true_ranges(scene, camera_to_world, directions)
    ranges, cosine = ranges.reshape(camera.height, camera.width), cosine.reshape(camera.height, camera.width)
    if rng is not None:
        ranges = _measured(ranges, cosine, sensor, rng)
    with np.errstate(invalid="ignore"):
        ranges = np.where((ranges >= sensor.range_min) & (ranges <= sensor.range_max), ranges, 0.0)
    return Scan.from_range(ranges, camera, camera_to_world=camera_to_world, source=source)


def miscalibrated(scan: Scan, *, scale: float, offset: float) -> Scan:
    """Return the scan as a camera with a relative range error ``scale`` and a constant ``offset`` (metres) reports it."""
    distance = np.linalg.norm(scan.points, axis=1, keepdims=True)
    points = scan.points * (1 + scale + offset / distance)
    image = np.full((int(np.prod(scan.shape or (0,))), 3), np.nan)
    if scan.shape is None or scan.pixels is None:
        return Scan.from_array(points, camera_to_world=scan.camera_to_world, source=scan.source)
    image[scan.pixels] = points
    return Scan.from_array(
        image.reshape(*scan.shape, 3), intrinsics=scan.intrinsics, camera_to_world=scan.camera_to_world, source=scan.source
    )


def pixel_directions(camera: Intrinsics, lateral_px: float, rng: np.random.Generator | None) -> Points:
    """Return (height * width, 3) unit directions of all pixels, each off by lateral noise of that many pixels."""
    rays = camera.rays()
    if rng is not None and lateral_px > 0:
        rays = rays + rng.normal(0.0, lateral_px, rays.shape) / (camera.fx, camera.fy)
    directions = np.column_stack([rays.reshape(-1, 2), np.ones(rays.shape[0] * rays.shape[1])])
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def true_ranges(scene: Scene, camera_to_world: Pose, directions: Points) -> tuple[Array, Array]:
    """Return (n,) ranges and cosines of incidence of (n, 3) unit rays from the camera; range inf where nothing is met."""
    world_to_camera = inverse(camera_to_world)
    up = world_to_camera[:3, 2]
    height = camera_to_world[2, 3]
    approach = -(directions @ up)
    with np.errstate(divide="ignore"):
        ranges = np.where(approach > 1e-9, height / np.maximum(approach, 1e-9), np.inf)
    cosine = np.maximum(approach, 0.0)
    for box in scene.boxes:
        seen = box.in_frame(world_to_camera)
        inside = np.flatnonzero(_could_hit(seen, directions))
        inside = inside[entry_mask(seen, directions[inside])]
        hits = box_hits(seen, directions[inside])
        nearer = hits.ranges < ranges[inside]
        ranges[inside[nearer]] = hits.ranges[nearer]
        cosine[inside[nearer]] = hits.cosine[nearer]
    return ranges, cosine


def _could_hit(box: Box, directions: Points) -> Array:
    """Return the (n,) mask of rays within the cone around the box's bounding sphere."""
    centre, radius = box.centre, np.linalg.norm(box.extents) / 2
    distance = float(np.linalg.norm(centre))
    if distance <= radius:
        return np.ones(len(directions), dtype=bool)
    return np.asarray(directions @ (centre / distance) >= np.sqrt(1 - (radius / distance) ** 2))


def _measured(ranges: Image, cosine: Image, sensor: Sensor, rng: np.random.Generator) -> Image:
    """Return true (h, w) ranges as the sensor reports them; NaN for a lost return."""
    sigma = sensor.range_sigma(np.minimum(ranges, sensor.range_max), cosine)
    axial = np.sqrt(np.maximum(sigma**2 - _slope_sigma(ranges, cosine, sensor) ** 2, 0.0))
    mixed = _mixed(ranges, sensor.flying_share, rng)
    noisy = mixed + axial * rng.standard_normal(ranges.shape)
    lost = rng.random(ranges.shape) < sensor.loss(cosine)
    return np.where(lost | ~np.isfinite(ranges), np.nan, noisy)


def _slope_sigma(ranges: Image, cosine: Image, sensor: Sensor) -> Image:
    """Return the part of the range noise that lateral noise causes: it is already in the ray directions."""
    bounded, cosine = np.minimum(ranges, sensor.range_max), np.maximum(cosine, 0.15)
    return np.asarray(sensor.lateral_px / sensor.intrinsics.fx * bounded * np.sqrt(1 - cosine**2) / cosine)


def _mixed(ranges: Image, share: float, rng: np.random.Generator) -> Image:
    """Return the ranges with a share of the pixels on depth edges mixed of their nearest and farthest neighbour."""
    finite = np.where(np.isfinite(ranges), ranges, 1e3)
    nearest, farthest = ndimage.minimum_filter(finite, 3), ndimage.maximum_filter(finite, 3)
    weight, chosen = rng.random(ranges.shape), rng.random(ranges.shape) < share
    edge = (farthest - nearest > EDGE_JUMP + 0.02 * nearest) & (farthest < 1e3)
    return np.where(edge & chosen, nearest + weight * (farthest - nearest), ranges)

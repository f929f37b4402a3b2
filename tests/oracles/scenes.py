"""Scans whose truth is known, and how to compare a measured box with it."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from viewgain.box import Box
from viewgain.camera import Intrinsics, Sensor, sensor
from viewgain.measure import BoxEstimate
from viewgain.scans import Scan
from viewgain.scenes import Scene, SceneRanges, orbit_pose, standing_box
from viewgain.simulate import Effects, capture

Array = NDArray[np.float64]

CAMERA = sensor("pico_flexx").without_systematic()
"""The default camera, perfectly calibrated: what a simulated scan without :func:`miscalibrated` shows."""
UNMIXED = Effects.only("noise", "loss")
"""No mixed pixels: for tests of the mathematics, not of how well it does at edges."""
MODELLED = Effects().without("multipath")
"""What the estimator knows of: light that comes by way of another surface is no part of its likelihood."""
WELL_SEEN = SceneRanges(extent=(0.15, 0.45), elevation_deg=(28.0, 50.0), distance=(1.0, 1.5), aim_sd=0.02)
"""Scenes in which nothing is cut or open: a box well inside the image, its top well in view."""


def corner_view(
    box: Box, *, azimuth_deg: float = 45.0, elevation_deg: float = 35.0, distance: float = 1.2, roll_deg: float = 0.0
) -> Array:
    """Return camera_to_world of a camera aimed at a box's centre; azimuth counts from the box's own +x side."""
    forward = box.box_to_camera[:3, 0]
    azimuth = float(np.arctan2(forward[1], forward[0])) + np.deg2rad(azimuth_deg)
    return orbit_pose(box.centre, azimuth, float(np.deg2rad(elevation_deg)), distance, float(np.deg2rad(roll_deg)))


def scan_of(
    *boxes: Box,
    view: Array,
    camera: Sensor = CAMERA,
    rng: np.random.Generator | None = None,
    effects: Effects = MODELLED,
    source: str = "simulated",
) -> Scan:
    """Return a scan of boxes from a view; a perfect camera without ``rng``."""
    return capture(Scene(boxes), view, camera, rng=rng, source=source, effects=effects)


def miscalibrated(scan: Scan, *, scale: float, offset: float) -> Scan:
    """Return the scan as a camera with a relative range error and a constant one (metres) reports it."""
    distance = np.linalg.norm(scan.points, axis=1, keepdims=True)
    return replace(scan, points=scan.points * (1 + scale + offset / distance))


def in_world(estimate: BoxEstimate, camera_to_world: Array) -> Box:
    """Return the measured box in the world."""
    return estimate.box.in_frame(camera_to_world)


def aligned_extents(measured: Box, truth: Box) -> Array:
    """Return the true extents along the axes of ``measured``, both in the same frame: their axes may be a quarter turn apart."""
    along = np.abs(measured.box_to_camera[:3, :3].T @ truth.box_to_camera[:3, :3])
    return np.asarray(truth.extents[np.argmax(along, axis=1)])


def relative_volume_error(estimate: BoxEstimate, truth: Box) -> float:
    """Return V / V* - 1."""
    return estimate.volume / float(np.prod(truth.extents)) - 1


def holds(interval: tuple[float, float | None], truth: float) -> bool:
    """Return whether an interval, perhaps without an upper end, holds the truth."""
    return interval[0] <= truth and (interval[1] is None or truth <= interval[1])


@dataclass(frozen=True, slots=True)
class BenchScan:
    """One scan of boxbench: an independent simulator's, so it tests ours."""

    name: str
    scan: Scan
    extents: Array
    sigma: float
    cut: bool

    @property
    def camera(self) -> Sensor:
        """The camera that took it: its noise is known, its calibration perfect."""
        return replace(CAMERA, noise_per_metre=self.sigma, jitter_px=0.3)


def read_bench(path: Path) -> BenchScan:
    """Return one file of boxbench."""
    with np.load(path) as file:
        ranges, (fx, fy), meta = file["range_u16"] * 1e-4, file["f"], json.loads(str(file["meta"]))
        camera_to_world = np.eye(4)
        camera_to_world[:3, :3], camera_to_world[:3, 3] = file["R"].T, file["eye"]
        extents = file["dims"].astype(float)
    height, width = ranges.shape
    camera = Intrinsics(width=width, height=height, fx=float(fx), fy=float(fy), cx=(width - 1) / 2, cy=(height - 1) / 2)
    scan = Scan.from_range(ranges, camera, camera_to_world=camera_to_world, source=path.stem)
    return BenchScan(path.stem, scan, extents, float(meta["sigma"]), meta["cut"] > 0)


__all__ = [
    "CAMERA", "WELL_SEEN", "BenchScan", "aligned_extents", "corner_view", "holds", "in_world", "read_bench",
    "relative_volume_error", "scan_of", "standing_box",
]  # fmt: skip

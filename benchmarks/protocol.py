"""A seeded generator of boxbench's protocol, so that the headline accuracy can be rerun without its files.

boxbench is 16 boxes x 4 positions x 2 noise levels from an independent simulator; this draws the same distributions with our
own. Run ``python -m benchmarks accuracy``: it measures both where the files are there.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from viewgain.camera import Intrinsics, Sensor
from viewgain.scans import Scan, read_scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import Effects, capture

BOXES, POSITIONS = 16, 4
NOISE_LEVELS = (0.005, 0.010)
DIMS = (0.1, 0.6)
RANGE_CUT = 2.2
EFFECTS = Effects.only("noise", "jitter", "mixing", "loss")
"""What boxbench has of the simulator's effects; its flying pixels are drawn, ours come from mixing."""


@dataclass(frozen=True)
class Sample:
    """One scan with its truth."""

    scan: Scan
    dims: NDArray[np.float64]
    """(3,) side lengths, metres."""
    azimuth_deg: float
    cut: bool
    """Whether any of the box's corners lies outside the image."""
    sensor: Sensor
    """The camera as the protocol describes it: noise, and no systematic error."""

    @property
    def folded_azimuth(self) -> float:
        """Angle between the line of sight and the nearest face's normal, 0 (face-on) to 45 (edge-on) degrees."""
        turned = self.azimuth_deg % 90
        return float(min(turned, 90 - turned))

    @property
    def view(self) -> NDArray[np.float64]:
        """(3,) folded azimuth and elevation, degrees, and distance, metres, all as to the box's centre."""
        assert self.scan.camera_to_world is not None
        sight = self.scan.camera_to_world[:3, 3] - (0.0, 0.0, self.dims[2] / 2)
        distance = float(np.linalg.norm(sight))
        return np.array([self.folded_azimuth, np.rad2deg(np.arcsin(sight[2] / distance)), distance])


@cache
def median_volume() -> float:
    """Return the median volume of the protocol's boxes, cubic metres: the answer of one who does not look."""
    return float(np.median(np.prod(np.random.default_rng(0).uniform(*DIMS, (10000, 3)), axis=1)))


def spread(samples: Sequence[Sample], count: int | None) -> list[Sample]:
    """Return ``count`` samples from all over, always the same; all of them for None, or if there are no more."""
    if count is None or count >= len(samples):
        return list(samples)
    return [samples[k] for k in sorted(np.random.default_rng(0).permutation(len(samples))[:count])]


def camera_of(name: str, noise: float, intrinsics: Intrinsics) -> Sensor:
    """Return the protocol's camera: noise sigma r / sqrt(cos), 0.3 px jitter, 70-85 degree loss, no systematic error.

    Its pixels look along one ray (mixed ones are drawn apart, without regard to brightness), so they have no footprint,
    and whole edges shift half as much as usual (chosen on generated(1), our own draw).
    """
    return Sensor(
        name=name,
        intrinsics=intrinsics,
        range_max=RANGE_CUT,
        noise_per_metre=noise,
        jitter_px=0.3,
        lateral_px=0.0,
        footprint_px=0.0,
        edge_sd_px=0.035,
        scale_sd=0.0,
        offset_sd=0.0,
    )


def generated(seed: int = 0) -> Iterator[Sample]:
    """Yield 128 scans drawn from boxbench's protocol by our own simulator."""
    rng = np.random.default_rng(seed)
    for number in range(BOXES):
        dims = rng.uniform(*DIMS, 3)
        box = standing_box(dims)
        name, intrinsics = _camera(rng, vga=number == 5)
        first = rng.uniform(0, 90)
        for position in range(POSITIONS):
            elevation, distance = rng.uniform(30, 50), rng.uniform(0.7, 1.5)
            for noise in NOISE_LEVELS:
                azimuth = first + 90 * position + rng.uniform(-5, 5)
                pose = orbit_pose(
                    box.centre + rng.normal(0, 0.03, 3),
                    np.deg2rad(azimuth),
                    np.deg2rad(np.clip(elevation + rng.uniform(-3, 3), 28, 53)),
                    float(np.clip(distance * rng.uniform(0.95, 1.05), 0.68, 1.58)),
                    np.deg2rad(rng.uniform(-4, 4)),
                )
                sensor = camera_of(name, noise, intrinsics)
                name_of_scan = f"b{number:02d}_p{position}_s{1e4 * noise:03.0f}"
                scan = capture(Scene((box,)), pose, sensor, rng=rng, effects=EFFECTS, source=name_of_scan)
                corners = box.in_frame(np.linalg.inv(pose)).corners()
                u, v = intrinsics.project(corners).T
                cut = bool(np.any((u < 0) | (v < 0) | (u > intrinsics.width - 1) | (v > intrinsics.height - 1)))
                yield Sample(scan, dims, azimuth, cut, sensor)


def boxbench(folder: Path) -> Iterator[Sample]:
    """Yield the 128 scans of boxbench."""
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as content:
            meta, dims = json.loads(str(content["meta"])), content["dims"]
        scan = read_scan(path)
        assert scan.intrinsics is not None
        yield Sample(scan, dims, meta["az"], meta["cut"] > 0, camera_of(meta["sensor"], meta["sigma"], scan.intrinsics))


def _camera(rng: np.random.Generator, *, vga: bool) -> tuple[str, Intrinsics]:
    if vga:
        return "vga640", Intrinsics.from_field_of_view(640, 480, *np.deg2rad([58.0, 45.0]))
    if rng.random() < 0.25:
        return "pico171", Intrinsics.from_field_of_view(171, 224, *np.deg2rad([45.0, 62.0]))
    return "pico224", Intrinsics.from_field_of_view(224, 171, *np.deg2rad([62.0, 45.0]))

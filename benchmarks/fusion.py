"""What do further views add, with poses and without? Several scans of one uncut box, fused, beside each of them alone."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Pose
from viewgain.box import Box, outline
from viewgain.camera import Sensor, sensor
from viewgain.episodes import World
from viewgain.measure import Measurement, measure
from viewgain.scenes import Scene, SceneRanges, random_box, random_view

MARGIN_PX = 3.0
_TRIES = 40


def views_of(box: Box, azimuths_deg: list[float], camera: Sensor, rng: np.random.Generator) -> list[Pose] | None:
    """Return a view from each azimuth that has the whole outline in the image; None where 40 tries find none."""
    views = []
    for azimuth in azimuths_deg:
        drawn = (random_view(rng, box, replace(SceneRanges(), azimuth_deg=(azimuth, azimuth))) for _ in range(_TRIES))
        whole = next((view for view in drawn if _is_whole(box, view, camera)), None)
        if whole is None:
            return None
        views.append(whole)
    return views


def _is_whole(box: Box, view: Pose, camera: Sensor) -> bool:
    corners = box.in_frame(np.linalg.inv(view)).corners()
    image = camera.intrinsics
    u = image.fx * corners[:, 0] / corners[:, 2] + image.cx
    v = image.fy * corners[:, 1] / corners[:, 2] + image.cy
    inside = (u > MARGIN_PX) & (v > MARGIN_PX) & (u < image.width - 1 - MARGIN_PX) & (v < image.height - 1 - MARGIN_PX)
    return bool(np.all(inside & (corners[:, 2] > 0.1)))


def azimuths(count: int, rng: np.random.Generator) -> list[float]:
    """Return where ``count`` cameras stand, degrees: two 60 to 180 apart, more of them all around, each off by up to 15."""
    first = float(rng.uniform(0, 360))
    if count == 2:
        return [first, first + float(rng.uniform(60, 180))]
    return [first + 360 * k / count + float(rng.uniform(-15, 15)) for k in range(count)]


def case(name: str, count: int, seed: int) -> tuple[Box, list[float], list[Measurement]]:
    """Return a box, the azimuths, and each scan measured alone, labelled with the pose its camera believes to be at."""
    rng = np.random.default_rng([seed, count, 29])
    camera = sensor(name).without_systematic()
    while True:
        box, at = random_box(rng), azimuths(count, rng)
        views = views_of(box, at, camera, rng)
        if views is not None:
            break
    world = World(Scene((box,)), camera)
    scans = [world.scan(world.arrive(view, rng), view, rng) for view in views]
    return box, at, [measure(scan, camera=camera) for scan in scans]

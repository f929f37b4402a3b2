"""A scene with its camera and stations, ready to be scanned; shared by boxes and meshes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Mask, Poses
from viewgain.camera import Sensor, sensor
from viewgain.geometry import inverse
from viewgain.rays import SceneCaster
from viewgain.rigs import Rig, Target, poses, refusals
from viewgain.simulate import NO_ERROR, Effects, RangeError, blocked

ELEVATION = float(np.deg2rad(35.0))
"""Of stations that leave it open, radians."""
DISTANCE = 1.2
"""Of stations that leave it open, metres."""
_NOISE = ("noise_constant", "noise_per_metre", "noise_per_square_metre", "noise_grazing")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Setup:
    """One object in its scene, and what looks at it."""

    caster: SceneCaster
    target: Target
    rig: Rig
    camera: Sensor
    noise: float
    """Factor that is already in the camera's noise."""
    effects: Effects
    error: RangeError = NO_ERROR

    def stations(self, rng: np.random.Generator | None = None) -> Poses:
        """Return the (V, 4, 4) poses of the stations in the world; with ``rng`` those that jittered cameras really have."""
        return poses(self.rig, self.target, elevation=ELEVATION, distance=DISTANCE, rng=rng)

    def reasons(self, cameras: Poses) -> list[str | None]:
        """Return why each camera cannot stand where it is; None where it can."""
        refused = refusals(self.rig, cameras, self.target)
        return [reason or blocked(self.caster.scene, camera[:3, 3]) for reason, camera in zip(refused, cameras, strict=True)]


def noisy_camera(names: Sequence[str], factors: Sequence[float], *, rng: np.random.Generator) -> tuple[Sensor, float]:
    """Return a camera drawn from ``names`` with its noise times a factor drawn from ``factors``, and the factor."""
    camera, factor = sensor(names[int(rng.integers(len(names)))]), float(factors[int(rng.integers(len(factors)))])
    return replace(camera, **{name: getattr(camera, name) * factor for name in _NOISE}), factor


def seen_from(view: int, present: Poses, stations: Poses) -> Poses:
    """Return (V, 4, 4) station poses in the present camera, the present view first."""
    return np.asarray(np.roll(inverse(present) @ stations, -view, axis=0))


def only_first(count: int) -> Mask:
    """Return (V,) the state after one view, the present one first."""
    return np.asarray(np.arange(count) == 0)

"""A depth camera looks at a scene. One page tells the method: what the rays meet, what light comes back, what is made of it."""

import numpy as np

from viewgain.arrays import Array, Pose
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.rays import Hits, SceneCaster, rays_through
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate._effects import ALL_EFFECTS, NO_EFFECTS, Effects
from viewgain.simulate._footprint import mixed_signal
from viewgain.simulate._memory import keep_freed_memory
from viewgain.simulate._multipath import bounces
from viewgain.simulate._receive import NO_ERROR, Draws, RangeError, received
from viewgain.simulate._signal import direct_signal


def capture(
    scene: Scene | SceneCaster,
    camera_to_world: Pose,
    sensor: Sensor,
    *,
    rng: np.random.Generator | None,
    effects: Effects | None = None,
    error: RangeError | None = None,
    frames: int = 1,
    source: str = "simulated",
) -> Scan:
    """Return one scan of a scene.

    Args:
        scene: What is seen; a caster saves preparing a mesh anew for every pose.
        camera_to_world: (4, 4) pose of the camera.
        sensor: The camera.
        rng: Source of all randomness; None for a perfect camera, whatever ``effects`` says; ``error`` still holds.
        effects: Which effects are on; default all.
        error: Systematic error of this particular camera; default none. See :func:`draw_range_error`.
        frames: Frames of the unmoved camera to average, at least 1; a pixel needs half of them.
        source: Name of the scan.

    Returns:
        An organised scan with the camera's intrinsics and pose, and the amplitude image (1 for white, head-on, at 1 m).

    Raises:
        ScanError: If fewer than 100 pixels return anything.
        ConfigError: If there is not one frame at least.
        MissingExtraError: If the caster names a backend that is not installed.
    """
    if frames < 1:
        raise ConfigError(f"got {frames} frames to average, wanted at least 1")
    keep_freed_memory()
    caster = scene if isinstance(scene, SceneCaster) else SceneCaster(scene)
    effects = NO_EFFECTS if rng is None else effects or ALL_EFFECTS
    streams = _streams(rng)
    hits = _look(caster, camera_to_world, sensor, streams["jitter"] if effects.jitter else None)
    bounced = None
    if effects.multipath and sensor.kind == "tof":
        bounced = bounces(hits, caster.surfaces, camera_to_world, sensor)
    total, valid, brightness = (np.zeros(len(hits.ranges)) for _ in range(3))
    for _ in range(frames):
        signal = direct_signal(hits, caster.surfaces)
        if effects.mixing or effects.lateral:
            lateral = streams["lateral"] if effects.lateral else None
            signal = mixed_signal(signal, hits, caster, camera_to_world, sensor, mixing=effects.mixing, rng=lateral)
        if bounced is not None:
            signal = bounced.added_to(signal)
        draws = _draws(len(hits.ranges), effects, streams)
        ranges, amplitude = received(signal, sensor, error or NO_ERROR, effects, draws)
        returned = np.isfinite(ranges)
        np.add(total, ranges, out=total, where=returned)
        valid += returned
        brightness += amplitude
    ranges = np.where(2 * valid >= frames, total / np.maximum(valid, 1), np.nan)
    amplitude = brightness / frames
    shape = (sensor.intrinsics.height, sensor.intrinsics.width)
    return Scan.from_range(
        ranges.reshape(shape),
        sensor.intrinsics,
        amplitude=amplitude.reshape(shape),
        camera_to_world=camera_to_world,
        source=source,
    )


def true_hits(scene: Scene | SceneCaster, camera_to_world: Pose, sensor: Sensor) -> Hits:
    """Return what the centres of all pixels see, row by row: exact, whatever the camera's noise."""
    caster = scene if isinstance(scene, SceneCaster) else SceneCaster(scene)
    return caster.pixels(sensor.intrinsics, camera_to_world)


_STREAMS = ("jitter", "lateral", "noise", "amplitude", "loss")


def _streams(rng: np.random.Generator | None) -> dict[str, np.random.Generator]:
    """Return one generator per effect, so that switching one effect leaves the draws of the others as they are."""
    seeds = np.zeros(len(_STREAMS), dtype=np.int64) if rng is None else rng.integers(2**63, size=len(_STREAMS))
    return {name: np.random.Generator(np.random.SFC64(int(seed))) for name, seed in zip(_STREAMS, seeds, strict=True)}


def _look(caster: SceneCaster, camera_to_world: Pose, sensor: Sensor, rng: np.random.Generator | None) -> Hits:
    """Return what the pixels see, through their centres or, with ``rng``, where they really look."""
    camera = sensor.intrinsics
    if rng is None or sensor.jitter_px == 0:
        return caster.pixels(camera, camera_to_world)
    v, u = np.mgrid[: camera.height, : camera.width].reshape(2, -1)
    shaken = np.stack([u, v], axis=-1) + rng.normal(0.0, sensor.jitter_px, (len(u), 2))
    return caster.rays(camera_to_world, rays_through(camera, shaken))


def _draws(count: int, effects: Effects, streams: dict[str, np.random.Generator]) -> Draws:
    nothing: Array = np.zeros(0)
    return Draws(
        noise=streams["noise"].standard_normal(count) if effects.noise else nothing,
        amplitude=streams["amplitude"].standard_normal(count) if effects.noise else nothing,
        loss=streams["loss"].random(count) if effects.loss else nothing,
    )

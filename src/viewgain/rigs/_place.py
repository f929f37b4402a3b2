"""From stations to poses. Both entry points share one geometry, in a frame with z up: the world's, or the floor's."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Pose, Poses, Rotation, Vector3
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, look_at, rotation_from_rotvec
from viewgain.rigs._rig import Rig, Station
from viewgain.rigs._target import Target

LOWEST = float(np.deg2rad(10.0))
"""A station that keeps the present elevation is placed no lower than this: from under the target's middle a ring would run into
the floor, radians."""
UP = np.array([0.0, 0.0, 1.0])
"""Up, in every frame of this module."""
FLIP = np.diag([1.0, -1.0, -1.0])
"""From our camera axes (x right, y down, z forward) to Blender's (x right, y up, z backward), and back."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Anchor:
    """What stations count from and fall back on, in the frame they are placed in."""

    azimuth: float
    elevation: float | None
    distance: float | None
    corner: int
    """The top corner that counts as number 0."""
    frame_to_world: Pose


def poses(
    rig: Rig,
    target: Target,
    *,
    azimuth: float = 0.0,
    elevation: float | None = None,
    distance: float | None = None,
    rng: np.random.Generator | None = None,
) -> Poses:
    """Return the (v, 4, 4) poses ``camera_to_world`` of a rig's stations around a target in the world (z up).

    Args:
        rig: The rig.
        target: What it stands around, world.
        azimuth: Direction that the stations' azimuths count from, radians from the world's x axis.
        elevation: For the stations that leave it open, radians.
        distance: For the stations that leave it open, metres.
        rng: Draws the rig's jitter; without it the cameras stand exactly where they should.

    Raises:
        ConfigError: If a station leaves elevation or distance open and none is given.
    """
    anchor = _Anchor(azimuth=azimuth, elevation=elevation, distance=distance, corner=0, frame_to_world=np.eye(4))
    return _stand_all(rig, target, anchor, rng)


def place(
    rig: Rig,
    target: Target,
    floor_to_current: Pose,
    camera_to_world: Pose | None,
    *,
    step_back: float = 1.0,
    rng: np.random.Generator | None = None,
) -> Poses:
    """Return the (v, 4, 4) poses ``camera_to_current`` of a rig's stations, anchored at the camera as it stands.

    Azimuths count from the present direction (of an absolute rig from the world's x axis), open elevations and distances keep
    their present value.

    Args:
        rig: The rig.
        target: What it stands around, in the floor's frame (the world where no pose is given; z up).
        floor_to_current: (4, 4) pose of that frame in the present camera.
        camera_to_world: (4, 4) pose of the present camera; needed only for absolute rigs and stations.
        step_back: Factor on the present distance for stations without one of their own.
        rng: Draws the rig's jitter; without it the cameras stand exactly where they should.

    Raises:
        ConfigError: If a station or the rig is given in the world and the scan has no pose.
    """
    if camera_to_world is None:
        _require_anchored(rig)
    floor_to_world = np.eye(4) if camera_to_world is None else camera_to_world @ floor_to_current
    here = inverse(floor_to_current)[:3, 3] - target.centre
    flat, radius = float(np.hypot(here[0], here[1])), float(np.linalg.norm(here))
    overhead = flat <= 0.02 * radius
    azimuth = -np.pi / 2 if overhead else float(np.arctan2(here[1], here[0]))  # straight overhead: below the image's middle
    anchor = _Anchor(
        azimuth=float(np.arctan2(floor_to_world[0, 1], floor_to_world[0, 0])) if rig.absolute else azimuth,
        elevation=max(float(np.arctan2(here[2], flat)), LOWEST),
        distance=step_back * radius,
        corner=int((azimuth - target.yaw) % (2 * np.pi) // (np.pi / 2)),
        frame_to_world=floor_to_world,
    )
    return np.asarray(floor_to_current @ _stand_all(rig, target, anchor, rng))


def _require_anchored(rig: Rig) -> None:
    if rig.absolute:
        raise ConfigError(f"rig {rig.name}: its azimuths count in the world, and the scan has no camera_to_world")
    for index, station in enumerate(rig.stations):
        if station.camera_to_world is not None:
            raise ConfigError(f"rig {rig.name}: station {index} is given in the world, and the scan has no camera_to_world")


def _stand_all(rig: Rig, target: Target, anchor: _Anchor, rng: np.random.Generator | None) -> Poses:
    errors = rig.jitter.draw(len(rig.stations), rng)
    return np.stack([_stand(station, target, anchor, error) for station, error in zip(rig.stations, errors, strict=True)])


def _stand(station: Station, target: Target, anchor: _Anchor, error: Array) -> Pose:
    """Return one camera in the anchor's frame; ``error`` is a row of :meth:`Jitter.draw`."""
    shift, miss = error[3:9].reshape(2, 3) @ target.target_to_world[:3, :3].T
    if station.camera_to_world is not None:
        camera = inverse(anchor.frame_to_world) @ station.camera_to_world
        camera[:3, 3] += shift
    else:
        aim, azimuth = _aim(station, target, anchor)
        azimuth += station.azimuth + error[0]
        elevation = _settled(station.elevation, anchor.elevation, "elevation") + error[1]
        distance = _settled(station.distance, anchor.distance, "distance") * (1 + error[2])
        level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        offset = distance * (np.cos(elevation) / _divisor(station, target) * level + np.sin(elevation) * UP)
        camera = _aimed(aim + offset + shift, aim + miss, level)
    camera[:3, :3] = turned(camera[:3, :3], error[9:])
    return camera


def _aim(station: Station, target: Target, anchor: _Anchor) -> tuple[Vector3, float]:
    """Return the (3,) point that a station looks at, and the azimuth that it counts from."""
    if station.corner is None:
        return target.centre, anchor.azimuth
    corner = target.top_corner(anchor.corner + station.corner)
    diagonal = corner - target.centre
    if not np.any(target.extents[:2]):  # no footprint, no diagonal
        return corner, anchor.azimuth + station.corner * np.pi / 2
    return corner, float(np.arctan2(diagonal[1], diagonal[0]))


def _divisor(station: Station, target: Target) -> float:
    """Return what the horizontal offset is divided by: 1, or with the authors' unnormalised direction the half diagonal."""
    half_diagonal = float(np.hypot(target.extents[0], target.extents[1])) / 2
    if station.unnormalised and half_diagonal == 0:
        raise ConfigError("an unnormalised station needs the target's extents; give them, or take paper4")
    return half_diagonal if station.unnormalised else 1.0


def _settled(value: float | None, fallback: float | None, name: str) -> float:
    if value is None and fallback is None:
        raise ConfigError(f"the rig leaves the {name} of a station open; give {name}")
    return float(value if value is not None else fallback)  # type: ignore[arg-type]


def _aimed(eye: Vector3, aim: Vector3, level: Vector3) -> Pose:
    """Return the upright camera at ``eye``. Straight overhead "up" is no guide; the image then keeps the ring's direction."""
    sight = eye - aim
    return look_at(eye, aim, UP if np.hypot(sight[0], sight[1]) > 1e-3 * np.linalg.norm(sight) else -level)


def turned(camera_to_world: Rotation, angles: Vector3) -> Rotation:
    """Return the (3, 3) rotation of a camera after (3,) ``angles`` are added to its Blender XYZ Euler angles, radians.

    Blender's angles (a, b, c) stand for Rz(c) Ry(b) Rx(a) of a camera with x right, y up, z backward in a world with z up.
    """
    if not np.any(angles):
        return camera_to_world
    r = camera_to_world @ FLIP
    cosine = float(np.hypot(r[0, 0], r[1, 0]))
    b = np.arctan2(-r[2, 0], cosine)
    if cosine > 1e-9:
        a, c = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    else:  # on its side: turns about x and z are one and the same
        a, c = np.arctan2(-r[1, 2], r[1, 1]), 0.0
    x, y, z = (rotation_from_rotvec(axis * angle) for axis, angle in zip(np.eye(3), angles + np.array([a, b, c]), strict=True))
    return np.asarray(z @ y @ x @ FLIP)

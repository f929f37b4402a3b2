"""``viewgain simulate``: scans of a simulated scene from every station of a rig, and the truth beside them."""

from collections import Counter
from typing import Literal

import numpy as np

from viewgain.camera import sensor
from viewgain.cli._commands import Simulate
from viewgain.cli._exit import NOTHING_MEASURED
from viewgain.errors import ConfigError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.meshes import TriangleMesh, read_mesh
from viewgain.rigs import Target, rig
from viewgain.scenes import Scene, Surroundings, random_scene, standing_box
from viewgain.shapes import procedural
from viewgain.simulate import Effects, RangeError, Recording, draw_range_error, record

CLUTTERED = Surroundings(boxes=(1, 4), clutter=(0, 3), walls=(0, 2), reflectivity=(0.2, 0.8))
"""What ``--scene random`` draws around the first box."""


def run_simulate(command: Simulate) -> int:
    """Simulate, write, and say what was written; exit code 3 if no station could take a scan."""
    if command.seed < 0:
        raise ConfigError(f"got seed {command.seed}, wanted a whole number from 0 on")
    camera = sensor(command.camera)
    scene, target = _scene(command)
    rng = _stream(command, "camera")
    recording = Recording(
        scene=scene,
        target=target,
        sensor=camera,
        rig=rig(command.rig),
        seed=command.seed,
        captures=command.captures,
        elevation=float(np.deg2rad(command.elevation)),
        distance=command.distance,
        effects=Effects().without(*command.without),
        error=draw_range_error(camera, rng=rng) if command.systematic else RangeError(),
        frames=command.frames,
        perfect=command.perfect,
        formats=tuple(command.formats),
        by_station=command.by_station,
    )
    shots = record(recording, command.out, workers=command.workers)
    taken = [shot for shot in shots if shot.name]
    for (station, reason), count in Counter((shot.station, shot.reason) for shot in shots if shot.reason).items():
        print(f"station {station}: {reason}, {count} of {command.captures} scans not taken")
    first = f", for instance {command.out / (taken[0].name or '')}.{recording.formats[0]}" if taken else ""
    print(f"{len(taken)} of {len(shots)} scans written to {command.out}{first}; the truth is in {command.out / 'truth.json'}")
    return 0 if taken else NOTHING_MEASURED


def _stream(command: Simulate, what: Literal["scene", "camera"]) -> np.random.Generator:
    """Return a generator of its own for what is drawn once; the scans draw from (seed, 1, station, capture)."""
    return np.random.default_rng([command.seed, {"scene": 2, "camera": 3}[what]])


def _scene(command: Simulate) -> tuple[Scene, Target]:
    """Return the scene that a command asks for, and what its rig stands around."""
    if not 0 < command.reflectivity <= 1:
        raise ConfigError(f"got a reflectivity of {command.reflectivity}, wanted one over 0 and up to 1")
    if command.mesh is not None and command.scene != "mesh":
        raise ConfigError(f"got --mesh {command.mesh} with --scene {command.scene}; a mesh file needs --scene mesh")
    if not np.isfinite(command.yaw):
        raise ConfigError(f"got a yaw of {command.yaw} degrees, wanted a finite angle")
    if command.scene == "random":
        scene = random_scene(_stream(command, "scene"), surroundings=CLUTTERED)
        return scene, Target(scene.boxes[0].box_to_camera, scene.boxes[0].extents)
    if command.scene == "box":
        if not (np.all(np.isfinite(command.dims)) and min(command.dims) > 0):
            raise ConfigError(f"got a box of {' x '.join(map(str, command.dims))} m, wanted three positive lengths")
        box = standing_box(np.array(command.dims), yaw=float(np.deg2rad(command.yaw)))
        return Scene((box,), reflectivity=(command.reflectivity,) * 2), Target(box.box_to_camera, box.extents)
    mesh = _mesh(command)
    if command.size is not None:
        mesh = mesh.normalised().scaled(command.size)
    mesh = mesh.moved(pose(rotation_from_rotvec(np.array([0.0, 0.0, np.deg2rad(command.yaw)])), np.zeros(3))).standing()
    return Scene(meshes=(mesh,), reflectivity=(command.reflectivity,) * 2), Target.at(
        (mesh.bounds[0] + mesh.bounds[1]) / 2, mesh.extents
    )


def _mesh(command: Simulate) -> TriangleMesh:
    if command.scene == "object":
        return procedural(command.category, rng=_stream(command, "scene"))
    if command.mesh is None:
        raise ConfigError("--scene mesh needs --mesh FILE")
    return read_mesh(command.mesh)

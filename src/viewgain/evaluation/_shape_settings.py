"""What is asked about objects of any shape: which objects, seen by which camera, from where."""

import dataclasses
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.camera import sensor
from viewgain.datasets import CoverageSettings, recipe
from viewgain.errors import ConfigError
from viewgain.evaluation._objects import RECIPE
from viewgain.evaluation._volume_case import LEAST_CAPTURES
from viewgain.meshes import MeshFolder
from viewgain.rigs import Rig, rig
from viewgain.shapes import CATEGORIES


def held_out() -> tuple[str, ...]:
    """Return the procedural categories that no shipped coverage network was trained on."""
    content = recipe(RECIPE).content
    assert isinstance(content, CoverageSettings)
    return content.held_out


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeSettings:
    """What is asked: objects, rig, camera. Two of equal settings are about the same objects and the same scans."""

    seed: int = 0
    """Source of all objects and scans, >= 0."""
    categories: tuple[str, ...] = ()
    """Kinds of objects, taken in turn; none for those of :func:`held_out`, or all of a folder of meshes."""
    meshes: Path | None = None
    """A folder of meshes (docs/meshes.md) with z up; None for procedural objects."""
    size: tuple[float, float] = (0.2, 0.8)
    """Shortest and longest diagonal of the box around an object along the axes of its mesh, uniform, metres."""
    rig: str = "ring8"
    """Positions: a preset or a rig file."""
    camera: str = "pico_flexx"
    """Camera: a preset or a file; each object has one of its own, with a systematic error drawn from what calibration leaves."""
    captures: int = 2
    """Scans of each position that score it; as many others are the oracle's."""
    distance: float = 1.2
    """For stations that leave it open, metres from the object's centre."""
    elevation_deg: float = 35.0
    """For stations that leave it open, degrees."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigError(f"evaluate shapes: got seed {self.seed}, wanted 0 or more")
        if self.captures < LEAST_CAPTURES:
            raise ConfigError(f"evaluate shapes: got {self.captures} captures, wanted {LEAST_CAPTURES} or more")
        if not 0 < self.size[0] <= self.size[1] < np.inf or not 0 < self.distance < np.inf:
            raise ConfigError(
                f"evaluate shapes: got sizes {self.size} and distance {self.distance}, wanted [low, high], positive and finite"
            )
        if not np.isfinite(self.elevation_deg):
            raise ConfigError(f"evaluate shapes: got elevation {self.elevation_deg}, wanted a finite number of degrees")
        self.stations()
        self.kinds()
        sensor(self.camera)

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain values for JSON."""
        return {**dataclasses.asdict(self), "meshes": None if self.meshes is None else str(self.meshes)}

    @property
    def fused(self) -> bool:
        """A position is worth what its scan and the present one say together."""
        return True

    def stations(self) -> Rig:
        """Return the rig."""
        return rig(self.rig)

    def kinds(self) -> tuple[str, ...]:
        """Return the kinds of objects, in turn; raises ConfigError if one is not known, MeshError if there is no mesh."""
        if self.meshes is not None:
            return (
                mesh_folder(self.meshes).only(self.categories).categories
                if self.categories
                else mesh_folder(self.meshes).categories
            )
        unknown = sorted(set(self.categories) - set(CATEGORIES))
        if unknown:
            raise ConfigError(f"categories: got {', '.join(unknown)}, wanted some of {', '.join(sorted(CATEGORIES))}")
        return self.categories or held_out()


@lru_cache(maxsize=4)
def mesh_folder(root: Path) -> MeshFolder:
    """Return the meshes of a folder, listed once; raises MeshError if there is none."""
    return MeshFolder.open(root)

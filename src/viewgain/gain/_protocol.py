"""Coverage protocols: which views, how many steps, how near a scan point has to come. Sources: PC-NBV, and the source paper."""

import math
from dataclasses import dataclass

from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageProtocol:
    """How coverage labels are made. Lengths are in units of the normalised mesh."""

    name: str
    """What it is called, e.g. "pcnbv"."""
    rig: str
    """The candidate views, a name of :func:`viewgain.rigs.rig`; their order is the order of the gains."""
    steps: int
    """Views that are chosen after the first one, >= 1."""
    surface_points: int = 16384
    """Samples of the surface that coverage is counted on."""
    reach: float = math.sqrt(0.00005)
    """A scan point covers the surface samples that are nearer than this, 0.00707 (the squares are compared)."""
    distance: float = 1.0
    """From the mesh's centre to every camera."""
    width: int = 640
    """Of the depth image, pixels."""
    height: int = 480
    """Of the depth image, pixels."""
    focal: float = 476.0
    """Focal length, pixels."""
    diagonal: float = 1.0
    """Of the normalised mesh's bounding box; 1 is the scale of ShapeNetCore v1."""

    def __post_init__(self) -> None:
        if self.steps < 1 or self.surface_points < 1:
            raise ConfigError(
                f"coverage protocol {self.name}: got {self.steps} steps, {self.surface_points} surface points, wanted at least 1"
            )
        for name in ("reach", "distance", "focal", "diagonal"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ConfigError(f"coverage protocol {self.name}: got {name} = {value}, wanted a positive number")

    @property
    def camera(self) -> Intrinsics:
        """The camera, a pinhole centred on its image.

        Raises:
            ConfigError: If the image has no pixels.
        """
        return Intrinsics(
            width=self.width,
            height=self.height,
            fx=self.focal,
            fy=self.focal,
            cx=(self.width - 1) / 2,
            cy=(self.height - 1) / 2,
        )


PCNBV = CoverageProtocol(name="pcnbv", rig="pcnbv33", steps=10)
"""PC-NBV's: 33 views, ten steps (Zeng et al. 2020, public scripts)."""
PAPER = CoverageProtocol(name="paper", rig="pcnbv16", steps=1)
"""The source paper's: the first 16 of those views, one step (its public logs)."""
COVERAGE_PROTOCOLS = {each.name: each for each in (PCNBV, PAPER)}
"""By name."""

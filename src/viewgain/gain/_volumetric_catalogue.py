"""The volumetric metrics by name. Adding one is one file and one line here."""

from typing import Protocol

from viewgain.arrays import Vector
from viewgain.gain._volumetric import GridKnown
from viewgain.gain._volumetric_area import AreaFactor
from viewgain.gain._volumetric_entropy import AverageEntropy, OcclusionAware, UnobservedVoxel
from viewgain.gain._volumetric_kriegel import Kriegel
from viewgain.gain._volumetric_proximity import ProximityCount
from viewgain.gain._volumetric_rear import RearSideEntropy, RearSideVoxel


class Volumetric(Protocol):
    """An objective on a voxel grid."""

    @property
    def name(self) -> str:
        """Name for tables."""
        ...

    def gains(self, known: GridKnown) -> Vector:
        """Return the (V,) gains of the candidates; comparable within one call only."""
        ...


VOLUMETRIC: dict[str, Volumetric] = {
    each.name: each
    for each in (
        OcclusionAware(),
        UnobservedVoxel(),
        RearSideVoxel(),
        RearSideEntropy(),
        ProximityCount(),
        AverageEntropy(),
        AreaFactor(),
        Kriegel(),
    )
}
"""Every volumetric metric with its defaults."""

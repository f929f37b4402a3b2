"""The volumetric metrics by name. Adding one is one file and one line here."""

from viewgain.gain._objective import Objective
from viewgain.gain._volumetric import GridKnown
from viewgain.gain._volumetric_area import AreaFactor
from viewgain.gain._volumetric_entropy import AverageEntropy, OcclusionAware, UnobservedVoxel
from viewgain.gain._volumetric_kriegel import Kriegel
from viewgain.gain._volumetric_proximity import ProximityCount
from viewgain.gain._volumetric_rear import RearSideEntropy, RearSideVoxel

VOLUMETRIC: dict[str, Objective[GridKnown]] = {
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

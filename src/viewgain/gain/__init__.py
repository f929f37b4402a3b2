"""What a view is worth: volumetric information gain."""

from viewgain.gain._volumetric import GridKnown as GridKnown
from viewgain.gain._volumetric_area import AreaFactor as AreaFactor
from viewgain.gain._volumetric_catalogue import VOLUMETRIC as VOLUMETRIC
from viewgain.gain._volumetric_catalogue import Volumetric as Volumetric
from viewgain.gain._volumetric_entropy import AverageEntropy as AverageEntropy
from viewgain.gain._volumetric_entropy import OcclusionAware as OcclusionAware
from viewgain.gain._volumetric_entropy import UnobservedVoxel as UnobservedVoxel
from viewgain.gain._volumetric_kriegel import Kriegel as Kriegel
from viewgain.gain._volumetric_proximity import ProximityCount as ProximityCount
from viewgain.gain._volumetric_rear import RearSideEntropy as RearSideEntropy
from viewgain.gain._volumetric_rear import RearSideVoxel as RearSideVoxel

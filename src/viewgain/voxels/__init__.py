"""A box of voxels that remembers what scans said about space: occupied, free, or never seen; and rays through it."""

from viewgain.voxels._camera import coarser as coarser
from viewgain.voxels._camera import pixels_per_voxel as pixels_per_voxel
from viewgain.voxels._evidence import Evidence as Evidence
from viewgain.voxels._evidence import evidence as evidence
from viewgain.voxels._evidence import evidence_of_rays as evidence_of_rays
from viewgain.voxels._grid import CERTAIN as CERTAIN
from viewgain.voxels._grid import OCTOMAP as OCTOMAP
from viewgain.voxels._grid import OccupancyModel as OccupancyModel
from viewgain.voxels._grid import VoxelGrid as VoxelGrid
from viewgain.voxels._lattice import Lattice as Lattice
from viewgain.voxels._march import Backend as Backend
from viewgain.voxels._march import Paths as Paths
from viewgain.voxels._march import march as march

"""Rays against scenes: the slab test for boxes and planes, the z-buffer and Embree for meshes, behind one interface."""

from viewgain.rays._caster import Backend as Backend
from viewgain.rays._caster import SceneCaster as SceneCaster
from viewgain.rays._embree import EmbreeMesh as EmbreeMesh
from viewgain.rays._hits import NOTHING as NOTHING
from viewgain.rays._hits import Hits as Hits
from viewgain.rays._hits import Surfaces as Surfaces
from viewgain.rays._pixels import as_rows as as_rows
from viewgain.rays._pixels import pixel_rays as pixel_rays
from viewgain.rays._pixels import rays_through as rays_through
from viewgain.rays._slabs import FACES_PER_BOX as FACES_PER_BOX
from viewgain.rays._slabs import BoxBody as BoxBody
from viewgain.rays._slabs import PlaneBody as PlaneBody
from viewgain.rays._slabs import Triple as Triple
from viewgain.rays._slabs import bodies_in_camera as bodies_in_camera
from viewgain.rays._slabs import cast_slabs as cast_slabs
from viewgain.rays._triangles import cast_plain as cast_plain
from viewgain.rays._zbuffer import zbuffer as zbuffer

"""The box itself: its geometry, how rays meet it, and its outline in an image, each with exact derivatives."""

from viewgain.box._box import CORNERS as CORNERS
from viewgain.box._box import FACES as FACES
from viewgain.box._box import FLOOR as FLOOR
from viewgain.box._box import PARAMETERS as PARAMETERS
from viewgain.box._box import PLANE_EXTENTS as PLANE_EXTENTS
from viewgain.box._box import PLANE_NORMALS as PLANE_NORMALS
from viewgain.box._box import TOP as TOP
from viewgain.box._box import Box as Box
from viewgain.box._box import adjoint as adjoint
from viewgain.box._raycast import Hits as Hits
from viewgain.box._raycast import box_hits as box_hits
from viewgain.box._raycast import entry_mask as entry_mask
from viewgain.box._raycast import floor_hits as floor_hits
from viewgain.box._raycast import range_jacobian as range_jacobian
from viewgain.box._raycast import range_jacobian_factors as range_jacobian_factors
from viewgain.box._silhouette import EdgeDistances as EdgeDistances
from viewgain.box._silhouette import Outline as Outline
from viewgain.box._silhouette import edge_cosines as edge_cosines
from viewgain.box._silhouette import edge_distances as edge_distances
from viewgain.box._silhouette import edge_end_jacobians as edge_end_jacobians
from viewgain.box._silhouette import edge_jacobian as edge_jacobian
from viewgain.box._silhouette import outline as outline

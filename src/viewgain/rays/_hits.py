"""Where rays meet a scene, and what they meet there."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Ids, Points, Vector

NOTHING = -1
"""Surface that a ray which meets nothing is given."""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """The first thing each ray meets."""

    ranges: Vector
    """(n,) distance along the unit ray, metres; inf where nothing is met."""
    surfaces: Ids
    """(n,) index into :class:`Surfaces`; :data:`NOTHING` where nothing is met."""
    cosine: Vector
    """(n,) cosine of the angle of incidence, in [0, 1]; 0 where nothing is met."""


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """The flat pieces of a scene: faces of boxes, triangles of meshes, planes, in this order."""

    normals: Points
    """(s + 1, 3) unit normals, world frame; the last row is zero and stands for :data:`NOTHING`."""
    patches: Ids
    """(s + 1,) the smooth patch each belongs to: a face, a whole mesh, a plane; -1 for nothing."""
    reflectivity: Array
    """(s + 1,) share of light given back; 0 for nothing."""

    def __len__(self) -> int:
        return len(self.patches) - 1

    def normals_of(self, surfaces: Ids) -> Points:
        """Return the (n, 3) normals of hit surfaces, world frame; zero for nothing."""
        return np.asarray(self.normals[surfaces])

"""Rays against triangles in plain numpy: slow, needs nothing else. And what all ways of casting share: planes, ranges, cosines.

All ways agree on what a hit is: both sides of a triangle count, its edges belong to it, a degenerate triangle is never hit, and
the range comes from the triangle's plane in float64, whatever arithmetic found the triangle.
"""

import numpy as np

from viewgain.arrays import Array, Ids, Points, Vector
from viewgain.meshes import TriangleMesh

START = 1e-6
"""A hit at this range (metres) or nearer is not a hit: the ray may start on the surface."""
PARALLEL = 1e-9
"""A ray whose cosine of incidence is below this runs along the triangle's plane and misses it."""
GRAZING = 0.01
"""Below this cosine of incidence the range is held between the ranges of the triangle's corners."""
FLAT = 1e-12
"""A triangle with less than this height over its longest side, relative to that side, is degenerate."""
EDGE = 1e-9
"""Slack of the barycentric coordinates, so that no ray slips between neighbours."""
BLOCK = 1 << 16
"""Pairs of ray and triangle that are looked at together: five arrays of this size stay in the cache."""


def face_planes(mesh: TriangleMesh) -> Array:
    """Return the (f, 4) planes (nx, ny, nz, offset) of the triangles: n.x = offset, metres, n of length 1.

    A degenerate triangle gets zeros.
    """
    corners = mesh.triangles
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_area = np.linalg.norm(normals, axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    solid = doubled_area > FLAT * longest**2
    normals = np.divide(normals, doubled_area[:, None], out=np.zeros_like(normals), where=solid[:, None])
    return np.column_stack([normals, np.einsum("ij,ij->i", normals, corners[:, 0])])


def incidence_cosines(planes: Array, triangles: Ids, directions: Array) -> Array:
    """Return the (...) cosines of incidence |n.d|, in [0, 1], where rays hit; 0 for a miss.

    Args:
        planes: (f, 4) from :func:`face_planes`, in the frame of ``directions``.
        triangles: (...) index of the triangle hit, -1 for a miss.
        directions: (..., 3) unit rays.
    """
    nx, ny, nz, _ = np.moveaxis(np.take(planes, triangles, axis=0), -1, 0)
    dx, dy, dz = np.moveaxis(directions, -1, 0)
    cosines = np.abs(nx * dx + ny * dy + nz * dz)
    return np.where(triangles >= 0, np.minimum(cosines, 1.0), 0.0)


def plane_ranges(mesh: TriangleMesh, planes: Array, triangles: Ids, origins: Array, directions: Points) -> Vector:
    """Return the (n,) ranges at which rays meet the planes of the triangles they hit, metres; inf for a miss.

    Args:
        mesh: The triangles, world frame.
        planes: (f, 4) from :func:`face_planes`.
        triangles: (n,) index of the triangle hit, not a degenerate one; -1 for a miss.
        origins: (3,) or (n, 3), metres, world frame.
        directions: (n, 3) unit rays, world frame.
    """
    nx, ny, nz, offset = np.take(planes, triangles, axis=0).T  # a miss reads the last plane, and is overwritten below
    dx, dy, dz = directions.T
    ox, oy, oz = origins.T
    approach = nx * dx + ny * dy + nz * dz  # by columns: twice as fast as by rows
    height = offset - (nx * ox + ny * oy + nz * oz)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ranges = height / approach
    ranges[triangles < 0] = np.inf
    grazing = np.flatnonzero((np.abs(approach) < GRAZING) & (triangles >= 0))
    if grazing.size:
        starts = origins if origins.ndim == 1 else origins[grazing, None]
        corners = mesh.vertices[mesh.faces[triangles[grazing]]] - starts
        along = np.einsum("ikj,ij->ik", corners, directions[grazing])
        low, high = along.min(axis=1), along.max(axis=1)
        held = np.where(np.isnan(ranges[grazing]), low, ranges[grazing])
        ranges[grazing] = np.clip(held, low, high)
    return np.asarray(ranges)


def cast_plain(mesh: TriangleMesh, origins: Array, directions: Points) -> tuple[Vector, Ids]:
    """Return where rays first meet a mesh, by trying every triangle: about 100 million pairs of ray and triangle a second.

    The three numerators of Moeller and Trumbore's solution are linear in the line's Pluecker coordinates (d, o x d), and in d
    alone for rays from one point; so a block of pairs is a few matrix products.

    Args:
        mesh: The triangles, world frame.
        origins: (3,) or (n, 3) where the rays start, metres, world frame. One shared origin is faster.
        directions: (n, 3) unit rays, world frame.

    Returns:
        (n,) ranges along the rays, metres, inf for a miss; (n,) int32 indices of the triangles hit, -1 for a miss. Of triangles
        at the same range the lowest index wins.

    Raises:
        ValueError: If the shapes of origins and directions do not fit.

    Source:
        Moeller and Trumbore (1997), Fast, minimum storage ray-triangle intersection. The matrix form is ours.
    """
    origins, directions = ray_arrays(origins, directions)
    planes = face_planes(mesh)
    solid = np.flatnonzero(planes[:, :3].any(axis=1))
    middle = origins if origins.ndim == 1 else mesh.bounds.mean(axis=0)
    first, second, third = np.moveaxis(mesh.triangles[solid] - middle, 1, 0)
    doubled_areas = np.linalg.norm(np.cross(second - first, third - first), axis=1)[:, None]
    side, other = (second - first) / doubled_areas, (third - first) / doubled_areas
    normals, offsets = planes[solid, :3], np.einsum("ij,ij->i", planes[solid, :3], first)
    to_u, to_v = np.cross(other, first), np.cross(first, side)
    lines, starts = directions, None
    if origins.ndim == 2:
        starts = origins - middle
        lines = np.hstack([directions, np.cross(starts, directions)])
        to_u, to_v = np.hstack([to_u, -other]), np.hstack([to_v, side])

    ranges = np.full(len(directions), np.inf)
    triangles = np.full(len(directions), -1, dtype=np.int32)
    width = max(min(len(solid), 512), 1)
    height = max(BLOCK // width, 1)
    for top in range(0, len(directions), height):
        rays = slice(top, top + height)
        for left in range(0, len(solid), width):
            some = slice(left, left + width)
            above = offsets[some] if starts is None else offsets[some] - starts[rays] @ normals[some].T
            found, nearest = _first_of_block(lines[rays], directions[rays] @ normals[some].T, above, to_u[some], to_v[some])
            nearer = np.flatnonzero(found < ranges[rays])
            ranges[rays][nearer] = found[nearer]
            triangles[rays][nearer] = solid[left + nearest[nearer]]
    return plane_ranges(mesh, planes, triangles, origins, directions), triangles


def _first_of_block(lines: Array, approach: Array, above: Array, to_u: Array, to_v: Array) -> tuple[Vector, Array]:
    """Return (r,) ranges, inf for a miss, and (r,) places in the block of the first of t triangles that r rays meet.

    Args:
        lines: (r, 3) directions or (r, 6) Pluecker coordinates.
        approach: (r, t) cosines n.d.
        above: (t,) or (r, t) distance from the ray's start to the plane along n.
        to_u: (t, 3) or (t, 6) such that to_u.line / approach is the first barycentric coordinate.
        to_v: The same for the second.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1 / approach
        u, v, at = (lines @ to_u.T) * inverse, (lines @ to_v.T) * inverse, above * inverse
        inside = (u >= -EDGE) & (v >= -EDGE) & (u + v <= 1 + EDGE) & (at > START) & (np.abs(approach) > PARALLEL)
    at[~inside] = np.inf
    nearest = np.argmin(at, axis=1)
    return at[np.arange(len(at)), nearest], nearest


def ray_arrays(origins: Array, directions: Points) -> tuple[Array, Points]:
    """Return origins, (3,) or (n, 3), and directions, (n, 3), as float64 arrays.

    Raises:
        ValueError: If they have other shapes.
    """
    origins, directions = np.asarray(origins, dtype=float), np.asarray(directions, dtype=float)
    if directions.ndim != 2 or directions.shape[1] != 3 or origins.shape not in ((3,), directions.shape):
        raise ValueError(f"got origins {origins.shape} and directions {directions.shape}, wanted (3,) or (n, 3) and (n, 3)")
    return origins, directions

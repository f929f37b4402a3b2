"""A depth image of a mesh by drawing its triangles: the fastest way for a pinhole camera. The optional extra ``data`` (numba).

The edges are planes through the camera's centre, so nothing is clipped and nothing divided before a pixel is known to be covered:
a triangle that passes beside or behind the camera is drawn as right as any other.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Faces, Image, Points, Vector
from viewgain.camera import Intrinsics
from viewgain.compiled import compiled
from viewgain.errors import ConfigError
from viewgain.rays._triangles import FLAT, PARALLEL, START

IndexImage: TypeAlias = NDArray[np.int32]
"""(h, w) index of the triangle seen, -1 for none."""
Fill: TypeAlias = Callable[[Points, Faces, Vector, Vector, Image, IndexImage], None]

MARGIN = 1e-3
"""Pixels by which a triangle's bounding box is widened, for rounding; the edges decide."""
ROUNDING = 16 * np.finfo(float).eps
"""Slack of an edge function, relative to the lengths that are multiplied in it: some 1e-15 of a triangle's distance."""


def zbuffer(vertices: Points, faces: Faces, intrinsics: Intrinsics, near: float = START) -> tuple[Image, IndexImage]:
    """Return what a pinhole camera sees of triangles, at the centres of its pixels.

    Both sides of a triangle are surface, its edges belong to it, and a degenerate one is never seen. Of triangles at the same
    depth the lowest index wins.

    Args:
        vertices: (v, 3) corners, metres, camera frame (x right, y down, z forward).
        faces: (f, 3) int32 indices into ``vertices``.
        intrinsics: The camera, without distortion.
        near: Surface at a depth below this is not seen, metres, > 0.

    Returns:
        (h, w) depths along z, metres, inf where nothing is seen; (h, w) int32 indices of the triangles, -1 for none. The range
        along a pixel's ray is its depth times the length of (x/z, y/z, 1).

    Raises:
        ConfigError: If the camera has distortion: straight edges are then not straight in its image. Cast rays instead.
        MissingExtraError: If numba is not installed.

    Source:
        Pineda (1988), A parallel algorithm for polygon rasterization, for the edge functions; Olano and Greer (1997), Triangle
        scan conversion using 2D homogeneous coordinates, for doing without clipping.
    """
    if intrinsics.distortion:
        raise ConfigError(f"z-buffer: got a lens with distortion {intrinsics.distortion}, wanted a pinhole; cast rays instead")
    if not near > 0:
        raise ConfigError(f"z-buffer: got a near depth of {near} m, wanted more than 0")
    lens = np.array([intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy])
    depth = np.full((intrinsics.height, intrinsics.width), np.inf)
    triangles = np.full(depth.shape, -1, dtype=np.int32)
    corners, triples = np.ascontiguousarray(vertices, dtype=float), np.ascontiguousarray(faces, dtype=np.int32)
    fill: Fill = compiled(_fill, "drawing a mesh")
    fill(corners, triples, lens, np.array([near, FLAT, PARALLEL]), depth, triangles)
    return depth, triangles


def _fill(vertices: Points, faces: Faces, lens: Vector, limits: Vector, depth: Image, triangles: IndexImage) -> None:
    """Draw triangles into an image of depths and one of indices, both changed in place.

    With corners a, b, c and a pixel's ray p = (x, y, 1), p.(a x b) is the edge function of the side from a to b. Swapping a and b
    negates it to the last bit, so two neighbours never both leave out a pixel between them; where many meet in a corner that is
    not enough, and a slack of the size of the rounding does the rest. The three functions add up to n.p with
    n = (b - a) x (c - a), and the depth is n.a / n.p. Written for numba: numbers and loops only.

    Args:
        vertices: (v, 3) corners, metres, camera frame.
        faces: (f, 3) indices.
        lens: (4,) fx, fy, cx, cy, pixels.
        limits: (3,) the least depth, metres, > 0; then FLAT and PARALLEL: machine code kept on disk would not notice if these, of
            another module, changed.
        depth: (h, w) nearest depth so far, inf for none.
        triangles: (h, w) its triangle, -1 for none.
    """
    height, width = depth.shape
    fx, fy, cx, cy = lens
    near, flat, parallel = limits
    columns, rows = (np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy
    steepest = np.sqrt(1 + np.max(np.abs(columns)) ** 2 + np.max(np.abs(rows)) ** 2)
    edges = np.empty((3, 4))
    for face in range(len(faces)):
        # The box, in pixels, around what lies in front of the near plane.
        left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
        for k in range(3):
            a, b = faces[face, k], faces[face, (k + 1) % 3]
            ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
            bx, by, bz = vertices[b, 0], vertices[b, 1], vertices[b, 2]
            if az >= near:
                u, v = ax / az * fx + cx, ay / az * fy + cy
                left, right, top, bottom = min(left, u), max(right, u), min(top, v), max(bottom, v)
            if (az >= near) != (bz >= near):
                share = (near - az) / (bz - az)
                u, v = (ax + share * (bx - ax)) / near * fx + cx, (ay + share * (by - ay)) / near * fy + cy
                left, right, top, bottom = min(left, u), max(right, u), min(top, v), max(bottom, v)
        if right < -MARGIN or bottom < -MARGIN or left > width - 1 + MARGIN or top > height - 1 + MARGIN:
            continue
        first_column, last_column = int(np.ceil(max(left - MARGIN, 0.0))), int(min(right + MARGIN, width - 1.0))
        first_row, last_row = int(np.ceil(max(top - MARGIN, 0.0))), int(min(bottom + MARGIN, height - 1.0))
        if first_column > last_column or first_row > last_row:
            continue  # it lies between the centres of pixels, as most triangles of a fine mesh do

        longest = 0.0
        for k in range(3):
            a, b = faces[face, k], faces[face, (k + 1) % 3]
            ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
            bx, by, bz = vertices[b, 0], vertices[b, 1], vertices[b, 2]
            edges[k, 0], edges[k, 1], edges[k, 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            size = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
            edges[k, 3] = ROUNDING * size * steepest
            longest = max(longest, (bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2)
        a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
        ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
        ux, uy, uz = vertices[b, 0] - ax, vertices[b, 1] - ay, vertices[b, 2] - az
        vx, vy, vz = vertices[c, 0] - ax, vertices[c, 1] - ay, vertices[c, 2] - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        doubled_area = np.sqrt(nx * nx + ny * ny + nz * nz)
        offset = nx * ax + ny * ay + nz * az
        if doubled_area <= flat * longest or abs(offset) <= parallel * doubled_area * np.sqrt(ax * ax + ay * ay + az * az):
            continue  # degenerate, or seen edge-on: the camera stands in its plane
        sign = 1.0 if offset > 0 else -1.0
        e0x, e0y, e0z = sign * edges[0, 0], sign * edges[0, 1], sign * edges[0, 2] + edges[0, 3]
        e1x, e1y, e1z = sign * edges[1, 0], sign * edges[1, 1], sign * edges[1, 2] + edges[1, 3]
        e2x, e2y, e2z = sign * edges[2, 0], sign * edges[2, 1], sign * edges[2, 2] + edges[2, 3]
        nx, ny, nz = nx / offset, ny / offset, nz / offset
        for row in range(first_row, last_row + 1):
            y = rows[row]
            e0, e1, e2, n = e0y * y + e0z, e1y * y + e1z, e2y * y + e2z, ny * y + nz
            for column in range(first_column, last_column + 1):
                x = columns[column]
                if e0x * x + e0 >= 0 and e1x * x + e1 >= 0 and e2x * x + e2 >= 0:
                    z = 1 / (nx * x + n)
                    if near <= z < depth[row, column]:
                        depth[row, column] = z
                        triangles[row, column] = face

"""Clouds whose planes are known: faces of a box sampled evenly, seen from the origin."""

import numpy as np
from numpy.typing import NDArray

from viewgain.planes._cloud import Cloud

Array = NDArray[np.float64]


def three_faces(dims: Array, pose: Array, *, pitch: float = 0.01, offset: float = 0.0) -> Cloud:
    """Return the cloud of the faces x = 0, y = 0, z = 0 of a box moved by ``pose``, with their true normals."""
    points, normals = [], []
    for axis in range(3):
        one, other = (k for k in range(3) if k != axis)
        u, v = np.meshgrid(*(np.arange(pitch / 2 + offset, dims[k], pitch) for k in (one, other)))
        face = np.zeros((u.size, 3))
        face[:, one], face[:, other] = u.ravel(), v.ravel()
        points.append(face)
        normals.append(np.tile(-np.eye(3)[axis], (u.size, 1)))
    rotation = pose[:3, :3]
    return Cloud(np.concatenate(points) @ rotation.T + pose[:3, 3], np.concatenate(normals) @ rotation.T)


def seen_corner(turn: float = 0.0) -> Array:
    """Return a pose that puts the box's corner 1 m before the camera with its three faces turned towards it."""
    z = np.array([1.0, 1.0, 1.0]) / np.sqrt(3)
    x = np.array([1.0, -1.0, 0.0]) / np.sqrt(2)
    basis = np.stack([x, np.cross(z, x), z])
    spin = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = spin @ basis, (0.02, -0.03, 1.0)
    return matrix

"""Rigid motions as 4x4 matrices named ``a_to_b``: they take coordinates in frame a to coordinates in frame b."""

import numpy as np

from viewgain.arrays import Points, Pose, Rotation, Vector3
from viewgain.errors import ConfigError


def pose(rotation: Rotation, translation: Vector3) -> Pose:
    """Return the rigid motion x -> rotation x + translation as a (4, 4) matrix; of stacks (..., 3, 3), (..., 3) a stack."""
    matrix = np.zeros((*rotation.shape[:-2], 4, 4))
    matrix[..., :3, :3] = rotation
    matrix[..., :3, 3] = translation
    matrix[..., 3, 3] = 1.0
    return matrix


def inverse(a_to_b: Pose) -> Pose:
    """Return ``b_to_a``; exact for rigid motions (transpose, no linear solve). Of a stack (..., 4, 4) a stack."""
    rotation = a_to_b[..., :3, :3].mT
    return pose(rotation, (-rotation @ a_to_b[..., :3, 3:])[..., 0])


def transform(a_to_b: Pose, points: Points) -> Points:
    """Return (..., 3) ``points`` of frame a in frame b; an empty array stays empty."""
    return np.asarray(points @ a_to_b[:3, :3].T + a_to_b[:3, 3])


def rotation_from_rotvec(rotvec: Vector3) -> Rotation:
    """Return the rotation by ``|rotvec|`` radians about ``rotvec`` (Rodrigues' formula); the zero vector gives identity."""
    angle = float(np.linalg.norm(rotvec))
    if angle < 1e-12:
        return np.eye(3) + cross_matrix(rotvec)
    k = cross_matrix(rotvec / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k))


def cross_matrix(v: Vector3) -> Rotation:
    """Return [v]x, the matrix with ``cross_matrix(v) @ w == cross(v, w)``; of a stack (..., 3) a stack."""
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = z, -y, x
    return matrix


def nearest_rotation(matrix: Rotation) -> Rotation:
    """Return the rotation closest to ``matrix`` in the Frobenius norm (orthogonal Procrustes by SVD)."""
    u, _, vt = np.linalg.svd(matrix)
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return np.asarray(u @ vt)


def look_at(eye: Vector3, target: Vector3, up: Vector3) -> Pose:
    """Return ``camera_to_world`` of a camera at ``eye`` that looks at ``target`` with image-up towards ``up``.

    Camera axes: x right, y down, z forward. When the line of sight is parallel to ``up`` (a camera straight overhead), the
    world's x axis (y where that is parallel too) takes the part of ``up``, so the pose is always defined.

    Raises:
        ConfigError: If ``eye`` equals ``target``.
    """
    forward = np.asarray(target, dtype=float) - eye
    distance = np.linalg.norm(forward)
    if distance == 0:
        raise ConfigError("a camera cannot look at its own centre: eye and target are the same point; move one of them")
    forward /= distance
    right = np.zeros(3)
    for reference in (np.asarray(up, dtype=float), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])):
        right = np.cross(forward, reference)
        if np.linalg.norm(right) > 1e-6 * np.linalg.norm(reference):
            break
    right /= np.linalg.norm(right)
    return pose(np.column_stack([right, np.cross(forward, right), forward]), np.asarray(eye, dtype=float))


def require_rigid(matrix: Pose, name: str) -> Pose:
    """Return ``matrix`` as float64 if it is a (4, 4) rigid motion.

    Raises:
        ConfigError: If the shape is wrong, a number is not finite, or the rotation is off by more than 1e-3.
    """
    matrix = np.asarray(matrix, dtype=float)
    if matrix.shape != (4, 4):
        raise ConfigError(f"{name}: got an array of shape {matrix.shape}, wanted a 4x4 pose matrix")
    rotation = matrix[:3, :3]
    rigid = (
        np.all(np.isfinite(matrix))
        and np.allclose(matrix[3], [0, 0, 0, 1], atol=1e-6)
        and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3)
        and np.linalg.det(rotation) > 0
    )
    if not rigid:
        raise ConfigError(f"{name}: the matrix is not a rigid motion (rotation and translation); give camera_to_world as 4x4")
    return pose(nearest_rotation(rotation), matrix[:3, 3])

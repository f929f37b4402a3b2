"""Rigid motions and planes: the little geometry that every other room stands on. Needs numpy only."""

from viewgain.geometry._plane import Plane as Plane
from viewgain.geometry._plane import fit_plane as fit_plane
from viewgain.geometry._plane import floor_to_camera as floor_to_camera
from viewgain.geometry._rigid import cross_matrix as cross_matrix
from viewgain.geometry._rigid import inverse as inverse
from viewgain.geometry._rigid import look_at as look_at
from viewgain.geometry._rigid import nearest_rotation as nearest_rotation
from viewgain.geometry._rigid import pose as pose
from viewgain.geometry._rigid import require_rigid as require_rigid
from viewgain.geometry._rigid import rotation_from_rotvec as rotation_from_rotvec
from viewgain.geometry._rigid import transform as transform

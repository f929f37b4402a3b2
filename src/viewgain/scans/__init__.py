"""Depth scans: the value object and the readers of every file format that depth cameras write."""

from viewgain.scans._intrinsics_file import read_intrinsics as read_intrinsics
from viewgain.scans._pose_file import read_pose as read_pose
from viewgain.scans._read import READERS as READERS
from viewgain.scans._read import read_scan as read_scan
from viewgain.scans._scan import MIN_POINTS as MIN_POINTS
from viewgain.scans._scan import Dropped as Dropped
from viewgain.scans._scan import Scan as Scan
from viewgain.scans._write import write_files as write_files
from viewgain.scans._write import write_scan as write_scan

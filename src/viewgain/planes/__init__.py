"""A box from orthogonal planes, the lines on which they meet and their corners: the source paper's estimator."""

from viewgain.planes._measure import measure_lines as measure_lines
from viewgain.planes._result import REASONS as REASONS
from viewgain.planes._result import SCHEMA as SCHEMA
from viewgain.planes._result import LineMeasurement as LineMeasurement
from viewgain.planes._settings import AS_PUBLISHED as AS_PUBLISHED
from viewgain.planes._settings import MENDED as MENDED
from viewgain.planes._settings import Method as Method
from viewgain.planes._settings import Settings as Settings

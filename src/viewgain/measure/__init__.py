"""From depth scans to measured boxes: floor, objects, maximum likelihood, error bars, flags."""

from viewgain.measure._calibrate import Calibration as Calibration
from viewgain.measure._calibrate import calibrate as calibrate
from viewgain.measure._fit import marginal as marginal
from viewgain.measure._floor import Floor as Floor
from viewgain.measure._floor import find_floors as find_floors
from viewgain.measure._fuse import POSE_SIGMA as POSE_SIGMA
from viewgain.measure._fuse import fuse as fuse
from viewgain.measure._fuse import fuse_measurements as fuse_measurements
from viewgain.measure._joint import pose_precision as pose_precision
from viewgain.measure._measure import measure as measure
from viewgain.measure._measure import sensor_of as sensor_of
from viewgain.measure._range_image import RangeImage as RangeImage
from viewgain.measure._range_image import range_image as range_image
from viewgain.measure._result import REASONS as REASONS
from viewgain.measure._result import SCHEMA as SCHEMA
from viewgain.measure._result import BoxEstimate as BoxEstimate
from viewgain.measure._result import Measurement as Measurement
from viewgain.measure._result import Rejected as Rejected
from viewgain.measure._result import floor_json as floor_json
from viewgain.measure._uncertainty import LOOSE_PRIOR as LOOSE_PRIOR
from viewgain.measure._uncertainty import PRIOR_EXTENT as PRIOR_EXTENT
from viewgain.measure._uncertainty import SYSTEMATIC as SYSTEMATIC
from viewgain.measure._uncertainty import Knowledge as Knowledge
from viewgain.measure._uncertainty import common_shift as common_shift
from viewgain.measure._uncertainty import without_edge_bias as without_edge_bias

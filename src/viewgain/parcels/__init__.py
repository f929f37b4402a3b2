"""Objects of any shape on the floor: smallest enclosing boxes, hull and heap volume, what parcel rules make of them."""

from viewgain.parcels._calibration import Calibration as Calibration
from viewgain.parcels._calibration import calibrated as calibrated
from viewgain.parcels._calibration import calibration as calibration
from viewgain.parcels._enclose import enclose as enclose
from viewgain.parcels._enclosure import REASONS as REASONS
from viewgain.parcels._enclosure import EnclosingBox as EnclosingBox
from viewgain.parcels._enclosure import Enclosure as Enclosure
from viewgain.parcels._enclosure import Enclosures as Enclosures
from viewgain.parcels._enclosure import Estimate as Estimate
from viewgain.parcels._objects import SeenObject as SeenObject
from viewgain.parcels._objects import find_objects as find_objects
from viewgain.parcels._rules import Billed as Billed
from viewgain.parcels._rules import Rules as Rules
from viewgain.parcels._rules import billed as billed
from viewgain.parcels._smallest import Cuboid as Cuboid
from viewgain.parcels._smallest import smallest_box as smallest_box
from viewgain.parcels._smallest import smallest_rectangle as smallest_rectangle
from viewgain.parcels._smallest import upright_box as upright_box
from viewgain.parcels._statistics import FEATURES as FEATURES
from viewgain.parcels._statistics import QUANTITIES as QUANTITIES
from viewgain.parcels._statistics import features as features
from viewgain.parcels._statistics import seen_and_possible as seen_and_possible
from viewgain.parcels._volumes import heap_volume as heap_volume
from viewgain.parcels._volumes import hull_volume as hull_volume

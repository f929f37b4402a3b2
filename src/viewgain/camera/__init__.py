"""Depth cameras: where each pixel looks, and how well it measures."""

from viewgain.camera._intrinsics import Intrinsics as Intrinsics
from viewgain.camera._presets import PRESETS as PRESETS
from viewgain.camera._presets import sensor as sensor
from viewgain.camera._sensor import Sensor as Sensor
from viewgain.camera._write import camera_text as camera_text

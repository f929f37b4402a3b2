"""Simulated scans of boxes on a floor: scenes, camera poses, and a depth camera with its noise and losses."""

from viewgain.simulate._capture import capture as capture
from viewgain.simulate._capture import miscalibrated as miscalibrated
from viewgain.simulate._capture import pixel_directions as pixel_directions
from viewgain.simulate._capture import true_ranges as true_ranges
from viewgain.simulate._scene import Scene as Scene
from viewgain.simulate._scene import SceneRanges as SceneRanges
from viewgain.simulate._scene import orbit_pose as orbit_pose
from viewgain.simulate._scene import random_box as random_box
from viewgain.simulate._scene import random_view as random_view
from viewgain.simulate._scene import standing_box as standing_box

"""Scenes: boxes, meshes, floor and walls, and seeded generators of them."""

from viewgain.scenes._random import SceneRanges as SceneRanges
from viewgain.scenes._random import orbit_pose as orbit_pose
from viewgain.scenes._random import random_box as random_box
from viewgain.scenes._random import random_view as random_view
from viewgain.scenes._random import standing_box as standing_box
from viewgain.scenes._scene import FLOOR as FLOOR
from viewgain.scenes._scene import GREY as GREY
from viewgain.scenes._scene import UP as UP
from viewgain.scenes._scene import Scene as Scene
from viewgain.scenes._scene import wall as wall
from viewgain.scenes._surroundings import Surroundings as Surroundings
from viewgain.scenes._surroundings import random_scene as random_scene

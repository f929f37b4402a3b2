"""Ordered candidate camera poses around a target, with jitter and limits: anchored at the present camera, or in the world."""

from viewgain.rigs._file import read_rig as read_rig
from viewgain.rigs._file import to_toml as to_toml
from viewgain.rigs._jitter import Jitter as Jitter
from viewgain.rigs._place import place as place
from viewgain.rigs._place import poses as poses
from viewgain.rigs._presets import RIGS as RIGS
from viewgain.rigs._presets import hemisphere as hemisphere
from viewgain.rigs._presets import irregular_rig as irregular_rig
from viewgain.rigs._presets import rig as rig
from viewgain.rigs._presets import ring as ring
from viewgain.rigs._reach import refusals as refusals
from viewgain.rigs._rig import KeepOut as KeepOut
from viewgain.rigs._rig import Rig as Rig
from viewgain.rigs._rig import Station as Station
from viewgain.rigs._target import Target as Target

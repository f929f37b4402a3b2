"""Closed-loop runs in simulation: a world the planner cannot see, and the episode it plays there."""

from viewgain.episodes._coverage import CoverageEpisode as CoverageEpisode
from viewgain.episodes._coverage import CoverageWorld as CoverageWorld
from viewgain.episodes._coverage import run_coverage_episode as run_coverage_episode
from viewgain.episodes._episode import Episode as Episode
from viewgain.episodes._episode import Step as Step
from viewgain.episodes._episode import World as World
from viewgain.episodes._episode import run_episode as run_episode
from viewgain.episodes._episode import volume_error as volume_error
from viewgain.episodes._network import NetworkExplorer as NetworkExplorer
from viewgain.episodes._oracles import CoverageOracle as CoverageOracle
from viewgain.episodes._oracles import VolumeOracle as VolumeOracle

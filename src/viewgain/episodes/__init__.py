"""Closed-loop runs in simulation: a world the planner cannot see, and the episode it plays there."""

from viewgain.episodes._episode import Episode as Episode
from viewgain.episodes._episode import Step as Step
from viewgain.episodes._episode import World as World
from viewgain.episodes._episode import run_episode as run_episode
from viewgain.episodes._episode import volume_error as volume_error

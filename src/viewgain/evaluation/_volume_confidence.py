"""What model and network say of a fresh box's positions, whoever chooses: how sure one can be of a choice rests on it."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from viewgain.evaluation._choice import seen_of
from viewgain.evaluation._volume_case import VolumeCase
from viewgain.inference import VOLUME_MODEL, PoseScorer
from viewgain.plan import (
    ExpectedErrorPolicy,
    OnBelief,
    Opinions,
    VolumeNetworkPolicy,
    trust,
)

ASKED: Mapping[bool, str] = {True: VOLUME_MODEL, False: "pose_scores-irregular4-camera"}
"""The shipped network of what a position is worth: fused with the present scan, or its scan alone."""


def opinions_of(case: VolumeCase) -> Opinions:
    """Return what model and network say of a case's positions by the scan to decide by.

    Raises:
        ModelError: If the shipped network cannot be read.
    """
    fused = case.settings.fused
    model = OnBelief(ExpectedErrorPolicy(fused=fused), case.camera)
    seen = model.measuring(seen_of(case))
    belief = model.belief(seen)
    by_network = VolumeNetworkPolicy(_network(ASKED[fused])).scores(seen)
    return Opinions(1 - model.scores(seen), -by_network, trust(belief, fused=fused), np.asarray(case.reachable))


@lru_cache(maxsize=2)
def _network(name: str) -> PoseScorer:
    return PoseScorer.load(name)

"""The networks that decide on a case: one that is told poses, or one of whole scans with the views of one rig."""

import hashlib
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError, ModelError
from viewgain.evaluation._choice import Question
from viewgain.gain import unrolled
from viewgain.inference import PoseScorer, Scorer, find_model
from viewgain.plan import Seen, ViewPolicy, VolumeNetworkPolicy


def kind_and_file(name: str) -> tuple[str, str]:
    """Return what kind of policy a name is of, and the file of its network; an empty one where none is named."""
    kind, _, file = name.partition(":")
    return kind, file


def network_of(name: str, settings: Question) -> ViewPolicy:
    """Return the policy of the network in a name, ``network:FILE``, ``combined:FILE``, ...; raises as :func:`policy_of`."""
    return _network_policy(kind_and_file(name)[1], rig=settings.stations().name)


def policy_key(name: str) -> str:
    """Return what stands for a policy in files that are kept: its name, with what is in the network's file for the file's name.

    Raises:
        ModelError: If there is no such file.
    """
    kind, file = kind_and_file(name)
    return f"{kind}:{hashlib.sha256(find_model(file).read_bytes()).hexdigest()}" if file else kind


@lru_cache(maxsize=4)
def _network_policy(file: str, *, rig: str) -> ViewPolicy:
    """Return the policy of a network file: one that is told poses, or one of whole scans with the views of one rig.

    Raises:
        ModelError: If there is no such file, or it is no network for volumes.
        ConfigError: If it is of another rig.
    """
    try:
        return VolumeNetworkPolicy(PoseScorer.load(file))
    except ModelError:
        scorer = Scorer.load(file)
    reason = scorer.refusal(frame="camera", rig=rig)
    if reason or scorer.card.normalisation != "metres":
        raise ConfigError(reason or f"{file}: scores coverage and not volumes; name a network that was trained for volumes")
    if scorer.card.with_view_state:
        raise ConfigError(f"{file}: wants to be told the visited views, and here none was visited; name a network without them")
    return StationNetworkPolicy(scorer)


@dataclass(frozen=True, slots=True, eq=False)
class StationNetworkPolicy:
    """A network with the views of its rig fixed, the present one first, as in the paper. It must know where it stands."""

    scorer: Scorer
    name: str = "network"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) scores in rig order; NaN where there is no scan or the camera stands near no station."""
        if not seen.scans:
            return np.full(len(seen.candidates), np.nan)
        here = seen.stands[-1, :3, 3]
        present = int(np.argmin(np.linalg.norm(seen.candidates[:, :3, 3] - here, axis=1)))
        return unrolled(self.scorer.scores(seen.scans[-1].points, frame="camera"), present)

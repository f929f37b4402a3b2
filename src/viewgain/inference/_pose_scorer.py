"""A network file that scores candidate poses of any rig from one scan. onnxruntime computes; torch is not needed."""

from functools import cache
from pathlib import Path

import numpy as np

from viewgain.arrays import Points, Poses
from viewgain.errors import ConfigError, ModelError
from viewgain.inference._card import POSE_KIND, ModelCard
from viewgain.inference._model_file import ModelFile, open_model
from viewgain.inference._normalise import checked, normalised, padded
from viewgain.inference._scores import Scores
from viewgain.inference._shipped import VOLUME_MODEL

POSE_INPUTS = ("points", "mask", "candidates")
"""Names of the inputs."""
ENOUGH = 8
"""Of a scan of more points than so many times what the network takes, so many are drawn first: looking for places that lie there
twice in all of a large scan would take longer than the rest."""


class PoseScorer:
    """A network of kind ``pose_scores`` and its card."""

    def __init__(self, file: ModelFile) -> None:
        """Take an open file; :meth:`load` opens one."""
        self._file = file

    @classmethod
    def load(cls, model: str | Path, *, threads: int = 1) -> "PoseScorer":
        """Return the network of a file, or of a shipped name.

        Raises:
            ModelError: If there is no such file or name, or it is damaged, of another program or of another kind.
            ConfigError: If ``threads`` is under 1.
        """
        file = open_model(model, threads)
        if file.card.kind != POSE_KIND or file.inputs != POSE_INPUTS:
            got = f"{file.card.kind} with inputs {', '.join(file.inputs)}"
            raise ModelError(f"{file.path}: is of kind {got}, wanted {POSE_KIND}; name another file")
        return cls(file)

    @property
    def card(self) -> ModelCard:
        """What the file says of itself."""
        return self._file.card

    def assessed(self, points: Points, candidates: Poses, *, seed: int = 0) -> Scores:
        """Return the score of every candidate, in their order.

        Args:
            points: (n, 3) a whole scan, metres, camera frame; of n points the card's number is drawn.
            candidates: (V, 4, 4) poses in that camera, V of 1 or more.
            seed: Of the draw.

        Raises:
            ScanError: If there are no points, or some are not finite.
            ConfigError: If there is no candidate, or one is not (4, 4).
            ModelError: If the network cannot be run, or gives what is not finite.
        """
        card, cloud, poses = self.card, checked(points, self.card), np.asarray(candidates, dtype=np.float32)
        if poses.ndim != 3 or poses.shape[1:] != (4, 4) or len(poses) == 0:
            raise ConfigError(f"network {card.name}: got candidates {poses.shape}, wanted (V, 4, 4), V of 1 or more")
        rng = np.random.default_rng(seed)
        if len(cloud) > ENOUGH * card.points:
            cloud = cloud[np.sort(rng.choice(len(cloud), ENOUGH * card.points, replace=False))]
        ready, mask = padded(normalised(cloud, card).astype(np.float32), card, rng=rng)
        return Scores.of(self._file.run(dict(zip(POSE_INPUTS, (ready, mask, poses[None]), strict=True))))


@cache
def volume_scorer() -> PoseScorer:
    """Return the shipped network that decides for the volume where none is named, opened once: that takes longer than asking.

    Raises:
        ModelError: If its file is missing or damaged.
    """
    return PoseScorer.load(VOLUME_MODEL)

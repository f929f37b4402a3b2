"""A network file that scores candidate poses of any rig from one scan. onnxruntime computes; torch is not needed."""

from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Points, Poses
from viewgain.errors import ConfigError, ModelError, ScanError, one_line
from viewgain.inference._card import POSE_KIND, ModelCard
from viewgain.inference._normalise import normalised, thinned
from viewgain.inference._scorer import POSE_INPUTS, Scores, opened_with_card
from viewgain.inference._shipped import find_model


class PoseScorer:
    """A network of kind ``pose_scores`` and its card."""

    def __init__(self, session: Any, card: ModelCard) -> None:
        """Take an open session of onnxruntime; :meth:`load` makes one."""
        self._session = session
        self.card = card

    @classmethod
    def load(cls, model: str | Path, *, threads: int = 1) -> "PoseScorer":
        """Return the network of a file, or of a shipped name.

        Raises:
            ModelError: If there is no such file or name, or it is damaged, of another program or of another kind.
            ConfigError: If ``threads`` is under 1.
        """
        if threads < 1:
            raise ConfigError(f"network: got {threads} threads, wanted at least 1")
        path = find_model(model)
        session, card = opened_with_card(path, threads)
        names = tuple(each.name for each in session.get_inputs())
        if card.kind != POSE_KIND or names != POSE_INPUTS:
            raise ModelError(
                f"{path}: is of kind {card.kind} with inputs {', '.join(names)}, wanted {POSE_KIND}; name another file"
            )
        return cls(session, card)

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
        cloud, poses = np.asarray(points, dtype=float), np.asarray(candidates, dtype=np.float32)
        if cloud.ndim != 2 or cloud.shape[1] != 3 or len(cloud) == 0 or not np.all(np.isfinite(cloud)):
            raise ScanError(f"network {self.card.name}: got points {cloud.shape}, wanted (n, 3) finite ones, n of 1 or more")
        if poses.ndim != 3 or poses.shape[1:] != (4, 4) or len(poses) == 0:
            raise ConfigError(f"network {self.card.name}: got candidates {poses.shape}, wanted (V, 4, 4), V of 1 or more")
        rng = np.random.default_rng(seed)
        if (
            len(cloud) > 8 * self.card.points
        ):  # looking for repeated places in all of a large scan would take longer than the rest
            cloud = cloud[np.sort(rng.choice(len(cloud), 8 * self.card.points, replace=False))]
        ready = normalised(cloud, self.card).astype(np.float32)
        kept = ready[thinned(ready, self.card.points, self.card.sampling, rng=rng)]
        padded = np.zeros((1, self.card.points, 3), dtype=np.float32)
        padded[0, : len(kept)] = kept
        mask = np.arange(self.card.points)[None] < len(kept)
        feed = dict(zip(POSE_INPUTS, (padded, mask, poses[None]), strict=True))
        try:
            output = self._session.run(None, feed)[0]
        except Exception as error:  # onnxruntime's errors share no base class of their own
            raise ModelError(f"network {self.card.name}: cannot be run ({one_line(error)}); get the file again") from error
        if not np.all(np.isfinite(output)):
            raise ModelError(f"network {self.card.name}: gave scores that are not finite; get the file again")
        if output.ndim == 2:
            return Scores(output[0].astype(float), None)
        return Scores(output[0, :, 0].astype(float), np.exp(0.5 * output[0, :, 1].astype(float)))

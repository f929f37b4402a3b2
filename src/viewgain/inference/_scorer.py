"""A network file, ready to score clouds. onnxruntime computes; torch is not needed."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewgain.arrays import Points
from viewgain.errors import ConfigError, ModelError
from viewgain.inference._card import POSE_KIND, FrameName, ModelCard
from viewgain.inference._model_file import ModelFile, open_model
from viewgain.inference._normalise import Bounds, checked, normalised, padded
from viewgain.inference._scores import CloudScorer, Scores

INPUTS = ("points", "mask", "view_state")
"""Names of the inputs; the last only where the card says so."""


class Scorer(CloudScorer):
    """A network and its card."""

    def __init__(self, file: ModelFile) -> None:
        """Take an open file; :meth:`load` opens one."""
        self._file = file

    @classmethod
    def load(cls, model: str | Path, *, threads: int = 1) -> "Scorer":
        """Return the network of a file, or of a shipped name.

        Args:
            model: Path of an ``.onnx`` file, or a name of :func:`viewgain.inference.shipped_models`.
            threads: Of onnxruntime; for single clouds one is often as fast as several.

        Raises:
            ModelError: If there is no such file or name, or it is damaged, of another program, or at odds with its card.
            ConfigError: If ``threads`` is under 1.
        """
        file = open_model(model, threads)
        _check_signature(file)
        return cls(file)

    @property
    def card(self) -> ModelCard:
        """What the file says of itself."""
        return self._file.card

    def refusal(self, *, frame: FrameName | None = None, rig: str | None = None) -> str | None:
        """Return why the network does not fit, or None; arguments as :meth:`CloudScorer.refusal`."""
        card = self.card
        if frame is not None and frame != card.frame:
            cure = "give the scan a pose (camera_to_world)" if card.frame == "object" else "give points as the camera sees them"
            return (
                f"network {card.name} was trained in the {card.frame} frame and the points are given in the {frame} frame; {cure}"
                f" or take a network of the {frame} frame"
            )
        if rig is not None and rig != card.rig:
            return f"network {card.name} ranks the views of rig {card.rig}, not of {rig}; take that rig or another network"
        return None

    def assessed(
        self,
        points: Points,
        view_state: ArrayLike | None = None,
        *,
        bounds: Bounds | None = None,
        frame: FrameName | None = None,
        seed: int = 0,
    ) -> Scores:
        """Return the scores of a cloud; arguments and errors as :meth:`CloudScorer.assessed`."""
        reason = self.refusal(frame=frame)
        if reason:
            raise ConfigError(reason)
        ready = normalised(checked(points, self.card), self.card, bounds).astype(np.float32)
        cloud, mask = padded(ready, self.card, rng=np.random.default_rng(seed))
        return Scores.of(self.run(cloud, mask, None if view_state is None else np.asarray(view_state)[None]))

    def run(self, points: NDArray[Any], mask: NDArray[np.bool_], view_state: ArrayLike | None = None) -> NDArray[np.float32]:
        """Return what the network gives for clouds that are ready: (B, V), or (B, V, 2) with uncertainty.

        Args:
            points: (B, n, 3) normalised points, no real one twice.
            mask: (B, n) which are real; n may be any number over the neighbours that the network looks at.
            view_state: (B, V), or None for networks that are not told.

        Raises:
            ConfigError: If the view state is missing or not wanted, or a shape does not fit.
            ModelError: If the result is not finite: the file is damaged.
        """
        card, feed = self.card, {"points": np.asarray(points, dtype=np.float32), "mask": np.asarray(mask, dtype=bool)}
        if (view_state is not None) != card.with_view_state:
            wanted = f"a view state of {card.views} numbers" if card.with_view_state else "no view state"
            raise ConfigError(f"network {card.name}: wanted {wanted}")
        if view_state is not None:
            feed["view_state"] = np.asarray(view_state, dtype=np.float32)
        shapes = [(*feed["points"].shape[:2], 3), feed["points"].shape[:2], (len(feed["points"]), card.views)]
        for name, shape in zip(INPUTS, shapes, strict=True):
            if name in feed and feed[name].shape != shape:
                raise ConfigError(f"network {card.name}: got {name} {feed[name].shape}, wanted {shape}")
        return self._file.run(feed)


def _check_signature(file: ModelFile) -> None:
    """Make sure that inputs and output are those of the card."""
    path, card = file.path, file.card
    if card.kind == POSE_KIND:
        raise ModelError(f"{path}: scores poses of candidates, not the views of one rig; use it with --objective volume")
    names, shape = file.inputs, file.output_shape
    if names != INPUTS[: 3 if card.with_view_state else 2] or shape not in ([card.views], [card.views, 2]):
        raise ModelError(f"{path}: got inputs {', '.join(names)} and scores {shape}, wanted those of its card; export it again")

"""A network file, ready to score clouds. onnxruntime computes; torch is not needed."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewgain.arrays import Points, Vector
from viewgain.errors import ConfigError, ModelError, ScanError, one_line
from viewgain.inference._card import POSE_KIND, FrameName, ModelCard
from viewgain.inference._normalise import Bounds, normalised, thinned
from viewgain.inference._shipped import find_model

CARD_KEY = "viewgain_card"
"""Where the card lies in the file's metadata."""
POSE_INPUTS = ("points", "mask", "candidates")
"""Names of the inputs of a network that is told the candidates' poses (:class:`viewgain.inference.PoseScorer`)."""
INPUTS = ("points", "mask", "view_state")
"""Names of the inputs; the last only where the card says so."""
_SILENT = 4


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """What a network says of every candidate view."""

    scores: Vector
    """(V,) the higher the better, in the card's order."""
    sigma: Vector | None
    """(V,) standard deviation of each, where the network gives one."""


class Scorer:
    """A network and its card."""

    def __init__(self, session: Any, card: ModelCard) -> None:
        """Take an open session of onnxruntime; :meth:`load` makes one."""
        self._session = session
        self.card = card

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
        if threads < 1:
            raise ConfigError(f"network: got {threads} threads, wanted at least 1")
        path = find_model(model)
        session, card = opened_with_card(path, threads)
        _check_signature(path, session, card)
        return cls(session, card)

    def refusal(self, *, frame: FrameName | None = None, rig: str | None = None) -> str | None:
        """Return why the network does not fit, or None.

        Args:
            frame: Where the points that it would get are given; None for where it wants them.
            rig: Name of the rig whose candidates are to be ranked; None for its own.
        """
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

    def scores(
        self,
        points: Points,
        view_state: ArrayLike | None = None,
        *,
        bounds: Bounds | None = None,
        frame: FrameName | None = None,
        seed: int = 0,
    ) -> Vector:
        """Return (V,) scores of a cloud in the card's order; arguments and errors as :meth:`assessed`."""
        return self.assessed(points, view_state, bounds=bounds, frame=frame, seed=seed).scores

    def assessed(
        self,
        points: Points,
        view_state: ArrayLike | None = None,
        *,
        bounds: Bounds | None = None,
        frame: FrameName | None = None,
        seed: int = 0,
    ) -> Scores:
        """Return the scores of a cloud, normalised by the card's rule and thinned to its number of points.

        Args:
            points: (n, 3) the object without its floor, in the card's frame, in any unit.
            view_state: (V,) true for visited views, in rig order; None for networks that are not told.
            bounds: Box of the whole object (rule ``whole_box``); None says that the points are normalised already.
            frame: Where the points are given; None for the card's.
            seed: Of the thinning.

        Raises:
            ScanError: If there are no points, or some are not finite.
            ConfigError: If the frame does not fit, the view state is missing or not wanted, or the points reach too far.
        """
        reason = self.refusal(frame=frame)
        if reason:
            raise ConfigError(reason)
        cloud = np.asarray(points, dtype=float)
        if cloud.ndim != 2 or cloud.shape[1] != 3 or len(cloud) == 0 or not np.all(np.isfinite(cloud)):
            raise ScanError(f"network {self.card.name}: got points {cloud.shape}, wanted (n, 3) finite ones, n of 1 or more")
        ready = normalised(cloud, self.card, bounds).astype(np.float32)
        kept = ready[thinned(ready, self.card.points, self.card.sampling, rng=np.random.default_rng(seed))]
        padded = np.zeros((1, self.card.points, 3), dtype=np.float32)
        padded[0, : len(kept)] = kept
        mask = np.arange(self.card.points)[None] < len(kept)
        output = self.run(padded, mask, None if view_state is None else np.asarray(view_state)[None])
        if output.ndim == 2:
            return Scores(output[0].astype(float), None)
        return Scores(output[0, :, 0].astype(float), np.exp(0.5 * output[0, :, 1].astype(float)))

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
        try:
            output: NDArray[np.float32] = self._session.run(None, feed)[0]
        except Exception as error:  # onnxruntime's errors share no base class of their own
            raise ModelError(f"network {card.name}: cannot be run ({one_line(error)}); get the file again") from error
        if not np.all(np.isfinite(output)):
            raise ModelError(f"network {card.name}: gave scores that are not finite; get the file again")
        return output


def opened_with_card(path: Path, threads: int) -> tuple[Any, ModelCard]:
    """Return a session of onnxruntime and the card in the file.

    Raises:
        ModelError: If the file is damaged, or of another program.
    """
    session = _opened(path, threads)
    text = session.get_modelmeta().custom_metadata_map.get(CARD_KEY)
    if text is None:
        raise ModelError(f"{path}: a network of another program (it has no viewgain card); use viewgain export")
    try:
        return session, ModelCard.from_json(text)
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from error


def _opened(path: Path, threads: int) -> Any:
    """Return a session of onnxruntime. The content is read first, so that the file cannot refer to others."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
    options.log_severity_level = _SILENT
    try:
        content = path.read_bytes()
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's errors share no base class of their own
        raise ModelError(f"{path}: cannot be read as a network ({one_line(error)}); get the file again") from error


def _check_signature(path: Path, session: Any, card: ModelCard) -> None:
    """Make sure that inputs and output are those of the card."""
    if card.kind == POSE_KIND:
        raise ModelError(f"{path}: scores poses of candidates, not the views of one rig; use it with --objective volume")
    names = tuple(each.name for each in session.get_inputs())
    outputs = session.get_outputs()
    shape = outputs[0].shape[1:]
    if names != INPUTS[: 3 if card.with_view_state else 2] or shape not in ([card.views], [card.views, 2]):
        raise ModelError(f"{path}: got inputs {', '.join(names)} and scores {shape}, wanted those of its card; export it again")

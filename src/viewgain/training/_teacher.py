"""Distillation: what a trained network says of the clouds of a batch, as further labels for another one (Hinton et al. 2015).

The teacher looks at the sample that the student looks at, turned or mirrored alike, with its own number of points and without
noise or hidden points: what it says stands beside the labels, which do not see those either.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import pad

from viewgain.errors import ConfigError, TrainingError
from viewgain.inference import POSE_KIND, ModelCard, Scorer, find_model, normalised
from viewgain.network import scores_of, unrepeated
from viewgain.training._batches import present_first
from viewgain.training._export import card_of
from viewgain.training._folder import RunFolder, RunRecord
from viewgain.training._load import load_trained
from viewgain.training._settings import TrainingRecipe

Answer: TypeAlias = Callable[[Tensor, Tensor, Tensor | None], Tensor]
"""From points (B, n, 3), a mask (B, n) and a view state (B, V) or None to what a network gives."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Teacher:
    """A trained network that labels clouds; its weights never change."""

    card: ModelCard
    """Of the teacher."""
    digest: str
    """SHA-256 of the file of its weights: a run goes on only with the same teacher."""
    uses_state: bool
    """Whether the student is told which views were visited, and answers in rig order."""
    answer: Answer
    """The network."""

    @property
    def points(self) -> int:
        """Points of a cloud that the teacher wants."""
        return self.card.points

    def scores(self, points: Tensor, mask: Tensor, states: Tensor, views: Tensor) -> Tensor:
        """Return (B, V) the teacher's scores in the student's order.

        Args:
            points: (B, n, 3) clouds as the data set has them.
            mask: (B, n) which points are real, at least one of each cloud.
            states: (B, V) visited views, rig order.
            views: (B,) the present view.
        """
        told = self.card.with_view_state
        with torch.no_grad():
            given = _by_rule(points, mask, self.card)
            output = self.answer(given, unrepeated(given, mask), states.float() if told else None)
            scores = scores_of(output.float()).to(points.device)
            return present_first(scores, views) if told and not self.uses_state else scores

    def facts(self) -> dict[str, str]:
        """Return what run.json keeps."""
        return {"name": self.card.name, "sha256": self.digest}


def open_teacher(recipe: TrainingRecipe, rig: str, device: str) -> Teacher | None:
    """Return the teacher of a recipe; None where it names none.

    Args:
        recipe: Of the student.
        rig: Name of the rig of the data.
        device: Where a teacher from a run computes; one from an ONNX file computes on the CPU.

    Raises:
        ConfigError: If it ranks another rig, wants points of another frame, learned other scores, or is not told which views
            were visited while the student is.
        ModelError: If there is no such file, or it is damaged.
        TrainingError: If it is a folder without a run that was trained.
    """
    if recipe.distil is None:
        return None
    path = Path(recipe.distil.teacher)
    card, file, answer = _of_run(path, device) if path.is_dir() else _of_file(recipe.distil.teacher)
    check_teacher(card, recipe, rig)
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    return Teacher(card=card, digest=digest, uses_state=recipe.network.with_view_state, answer=answer)


def placed(recipe: TrainingRecipe, teacher: Path | None = None) -> TrainingRecipe:
    """Return the recipe with the teacher at a place that holds wherever the run goes on.

    Args:
        recipe: The recipe.
        teacher: Where its teacher is; None for where the recipe says.

    Raises:
        ConfigError: If a teacher is named and the recipe has none.
    """
    if recipe.distil is None:
        if teacher is not None:
            raise ConfigError(f"train: got the teacher {teacher} for a run that has none; leave it out")
        return recipe
    path = Path(recipe.distil.teacher) if teacher is None else teacher
    return replace(recipe, distil=replace(recipe.distil, teacher=str(path.absolute() if path.exists() else path)))


def check_same(teacher: Teacher | None, before: RunRecord | None) -> None:
    """Make sure that a run goes on with the teacher that it began with.

    Raises:
        TrainingError: If it is another one.
    """
    if teacher is not None and before is not None and before.facts.get("teacher") != teacher.facts():
        raise TrainingError(
            f"distil: got the teacher {teacher.card.name}, which is not the file that the run began with; name that one with"
            " --teacher"
        )


def _of_run(path: Path, device: str) -> tuple[ModelCard, Path, Answer]:
    trained = load_trained(path)
    module = trained.module.requires_grad_(False).to(device)
    return card_of(trained), RunFolder(path).best, module


def _of_file(model: str) -> tuple[ModelCard, Path, Answer]:
    scorer = Scorer.load(model, threads=torch.get_num_threads())

    def answer(points: Tensor, mask: Tensor, states: Tensor | None) -> Tensor:
        missing = max(scorer.card.points - points.shape[1], 0)  # a file wants more points than neighbours
        filled, real = pad(points, (0, 0, 0, missing)), pad(mask, (0, missing))
        state = None if states is None else states.cpu().numpy()
        return torch.from_numpy(scorer.run(filled.cpu().numpy(), real.cpu().numpy(), state))

    return scorer.card, find_model(model), answer


def _by_rule(points: Tensor, mask: Tensor, card: ModelCard) -> Tensor:
    """Return the clouds normalised as the teacher knows them.

    Those of a data set are so by the whole object's box already; whole scans hold what lies about the middle already, as far as
    the student learns from it (:func:`check_teacher`).
    """
    if card.normalisation != "seen_box":
        return points
    ready = torch.zeros_like(points)
    for cloud, given, real in zip(ready, points, mask, strict=True):
        moved = normalised(given[real].double().cpu().numpy(), card)
        cloud[real] = torch.from_numpy(moved.astype(np.float32)).to(points.device)
    return ready


def check_teacher(card: ModelCard, recipe: TrainingRecipe, rig: str) -> None:
    """Refuse a teacher whose scores mean something else than the student's."""
    if card.kind == POSE_KIND:
        raise ConfigError(f"distil: got the teacher {card.name}, which scores poses and not the views of a rig; take another")
    taught = card.training.get("target", recipe.data.target)
    for what, got, wanted in (
        ("rig", card.rig, rig),
        ("views", card.views, recipe.network.views),
        ("frame", card.frame, recipe.data.frame),
        ("scores", taught, recipe.data.target),
        ("points within", card.within, recipe.data.within),
    ):
        if got != wanted:
            raise ConfigError(
                f"distil: got the teacher {card.name} of {what} {got}, wanted {wanted} as the student; take another"
            )
    if recipe.network.with_view_state and not card.with_view_state:
        raise ConfigError(
            f"distil: got the teacher {card.name}, which is not told what was visited, for a student that is; wanted one with the"
            " view state (the other way round is well)"
        )

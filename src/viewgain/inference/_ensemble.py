"""Several networks for the same question, asked together: where they disagree, none of them should be trusted."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from viewgain.arrays import Points
from viewgain.errors import ConfigError
from viewgain.inference._card import FrameName, ModelCard
from viewgain.inference._normalise import Bounds
from viewgain.inference._scorer import Scorer
from viewgain.inference._scores import CloudScorer, Scores


class Ensemble(CloudScorer):
    """The equal mixture of what its members say, asked like one of them.

    Score: the mean of the members' scores. Variance: the mean of their variances, where they give any, plus the mean squared
    distance of their scores from the mean. One member alone is itself.

    Source: Lakshminarayanan et al. 2017, section 2.4.
    """

    def __init__(self, members: Sequence[Scorer]) -> None:
        """Take the members; each keeps its own number of points and rule of normalisation.

        Raises:
            ConfigError: If there is none, or they rank other rigs, frames or orders, or only some give standard deviations.
        """
        if not members:
            raise ConfigError("ensemble: got no network, wanted one or more")
        self.members = tuple(members)
        first = members[0].card
        for card in (member.card for member in members[1:]):
            for what in ("rig", "views", "frame", "order", "uncertainty"):
                got, wanted = getattr(card, what), getattr(first, what)
                if got != wanted:
                    raise ConfigError(f"ensemble: got {what} {got} of {card.name} and {wanted} of {first.name}, wanted the same")

    @classmethod
    def load(cls, models: Sequence[str | Path], *, threads: int = 1) -> "Ensemble":
        """Return the networks of some files or shipped names; arguments and errors as :meth:`Scorer.load`, and of the class."""
        return cls([Scorer.load(model, threads=threads) for model in models])

    @property
    def card(self) -> ModelCard:
        """The first member's card under a name of all; with a standard deviation wherever there are several."""
        first = self.members[0].card
        if len(self.members) == 1:
            return first
        names = " and ".join(member.card.name for member in self.members)
        parameters = sum(member.card.parameters for member in self.members)
        return replace(first, name=names, uncertainty=True, parameters=parameters)

    def refusal(self, *, frame: FrameName | None = None, rig: str | None = None) -> str | None:
        """Return why the networks do not fit, or None; arguments as :meth:`CloudScorer.refusal`."""
        return self.members[0].refusal(frame=frame, rig=rig)

    def assessed(
        self,
        points: Points,
        view_state: ArrayLike | None = None,
        *,
        bounds: Bounds | None = None,
        frame: FrameName | None = None,
        seed: int = 0,
    ) -> Scores:
        """Return mean scores and the standard deviations of the mixture; arguments and errors as :meth:`CloudScorer.assessed`."""
        said = [member.assessed(points, view_state, bounds=bounds, frame=frame, seed=seed) for member in self.members]
        if len(said) == 1:
            return said[0]
        scores = np.stack([each.scores for each in said])
        variances = [np.square(each.sigma) for each in said if each.sigma is not None]
        own = np.mean(variances, axis=0) if variances else 0.0
        return Scores(scores.mean(axis=0), np.sqrt(scores.var(axis=0) + own))

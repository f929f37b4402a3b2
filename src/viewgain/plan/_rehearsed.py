"""The policy that tries before it goes: the expected error, corrected by rehearsals of the candidates that contend (ours).

What is expected of a candidate counts as much as :data:`WORTH` rehearsals: were a run a hit or a miss, this would be the mean of
a Beta distribution. Candidates that are surely worse are left alone, so effort goes where the choice is (racing, Maron and Moore
1994; docs/volume_nbv.md); a favourite is tried as well before it wins.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Pose, Poses, Vector
from viewgain.errors import ConfigError
from viewgain.gain import VolumeEstimator, volume_estimator
from viewgain.measure import POSE_SIGMA
from viewgain.plan._belief import Belief
from viewgain.plan._expected import ExpectedErrorPolicy
from viewgain.plan._fused_rehearsal import fused_trial
from viewgain.plan._policy import Assessment
from viewgain.plan._rehearsal import Arrivals, Trial, arriving_within, trials

WORTH = 4.0
"""As many rehearsals as the expected error is worth."""
ROUND, MOST = 4, 24
"""Rehearsals of a candidate before contenders are looked for anew, and the most of any; the one divides the other."""
APART = 2.0
"""A candidate contends while it may be the best: within so many standard deviations of the difference."""


@dataclass(frozen=True, slots=True, eq=False)
class RehearsedPolicy:
    """The least volume error after a candidate's scan, by what is expected of it and by rehearsals (:mod:`._rehearsal`).

    Where the box is only guessed at, rehearsals would be of something else: there the expected error decides.
    """

    estimator: VolumeEstimator | None = None
    """Who measures a scan alone; None for the default estimator, the only one that fuses."""
    fused: bool = False
    """Whether the candidate's scan is fused with those so far (:mod:`._fused_rehearsal`), or has to measure the box alone."""
    pose_sigma: tuple[float, float] = POSE_SIGMA
    """Standard deviation of camera poses, metres and radians per axis."""
    arrivals: Arrivals | None = None
    """Where cameras arrive that are sent to the candidates; None: about them, by ``pose_sigma``."""
    reachable: Mask | None = None
    """(V,) candidates that can be chosen; nothing is rehearsed of others. None for all."""
    seed: int = 0
    """Source of all randomness: the same belief and candidates give the same scores."""
    name: str = "rehearsed"

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate: 1 minus the error, and of those that were tried a bound of its standard deviation.

        A rehearsal takes as long as simulating and measuring a scan; at most ``MOST`` of each candidate.

        Raises:
            ConfigError: If ``reachable`` is not of these candidates, or an estimator is given that is to fuse.
        """
        del tolerance
        if self.fused and self.estimator is not None:
            raise ConfigError("rehearsed: got fused and an estimator, which measures scans alone; give one of the two")
        by_box = ExpectedErrorPolicy(self.fused, self.pose_sigma).errors(belief, candidates)
        standing = Standing.before(by_box.mean(axis=0))
        if not belief.guessed:
            standing = self._rehearsed(standing, by_box, belief, candidates)
        rows = zip(standing.errors.tolist(), standing.sigma.tolist(), standing.tried > 0, strict=True)
        return tuple(Assessment(1 - error, None, None, sigma if tried else None) for error, sigma, tried in rows)

    def among(self, reachable: Mask) -> "RehearsedPolicy":
        """Return the policy that rehearses none but those (V,) candidates."""
        return replace(self, reachable=reachable)

    def _rehearsed(self, standing: "Standing", by_box: Array, belief: Belief, candidates: Poses) -> "Standing":
        arrivals = self.arrivals or arriving_within(len(candidates), self.pose_sigma)
        allowed = self._allowed(len(candidates))
        if allowed.sum() < 2:
            return standing
        tries = trials(belief, arrivals, np.random.default_rng(self.seed))
        for _ in range(0, MOST, ROUND):
            contenders = standing.contenders(allowed)
            if len(contenders) == 1 and standing.tried[contenders] > 0:
                break
            for trial in islice(tries, ROUND):
                outcome = self._outcome(trial, belief)
                found = [outcome(index, candidates[index]) for index in contenders.tolist()]
                standing = standing.after(contenders, np.array(found) - by_box[trial.of, contenders])
        return standing

    def _outcome(self, trial: Trial, belief: Belief) -> Callable[[int, Pose], float]:
        """Return what comes of going to a candidate, by its index and pose."""
        if self.fused:
            return fused_trial(trial, belief.cameras, belief.sensor, self.pose_sigma).outcome
        return partial(trial.outcome, estimator=self.estimator or volume_estimator("default", belief.sensor))

    def _allowed(self, count: int) -> Mask:
        """Return (count,) candidates that can be chosen."""
        if self.reachable is None:
            return np.ones(count, dtype=bool)
        if self.reachable.shape != (count,):
            raise ConfigError(f"rehearsed: got reachable {self.reachable.shape} for {count} candidates, wanted one for each")
        return self.reachable


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """What is expected of V candidates, and what rehearsals have added to it."""

    expected: Vector
    """(V,) expected error, the mean over all boxes believed in."""
    surprise: Vector
    """(V,) sum over rehearsals of what came out less what was expected of that box."""
    tried: Vector
    """(V,) number of rehearsals."""

    @classmethod
    def before(cls, expected: Vector) -> "Standing":
        """Return where candidates stand without any rehearsal."""
        return cls(expected, np.zeros(len(expected)), np.zeros(len(expected)))

    @property
    def errors(self) -> Vector:
        """(V,) error to expect by now, 0 to 1."""
        return np.clip(self.expected + self.surprise / (WORTH + self.tried), 0.0, 1.0)

    @property
    def sigma(self) -> Vector:
        """(V,) its standard deviation if every run were a hit or a miss, of a Beta distribution; the most that it can be."""
        return np.sqrt(self.errors * (1 - self.errors) / (WORTH + self.tried + 1))

    def after(self, at: Indices, surprises: Vector) -> "Standing":
        """Return where they stand after one more rehearsal of those ``at``, and by how much each came out worse than expected."""
        surprise, tried = self.surprise.copy(), self.tried.copy()
        surprise[at] += surprises
        tried[at] += 1
        return Standing(self.expected, surprise, tried)

    def contenders(self, allowed: Mask) -> Indices:
        """Return the allowed candidates, one at least, that may still be the best, ascending: one where it is clear which."""
        errors, sigma = np.where(allowed, self.errors, np.inf), self.sigma
        best = int(np.argmin(errors))
        return np.flatnonzero(allowed & (errors - errors[best] <= APART * np.hypot(sigma, sigma[best])))

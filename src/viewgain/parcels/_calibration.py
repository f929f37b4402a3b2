"""From what is seen to an interval that holds the truth: quantile regression on simulated scans, then conformal (docs/shapes.md).

For each quantity the logarithm of truth over seen value has three quantiles, each linear in the features of the scan (Koenker and
Bassett 1978). The outer two are moved out until 5 % of held-out scans, of other kinds of objects, lie beyond each (conformalised
quantile regression, Romano et al. 2019). The file calibration.json holds the result and says on what it was made.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from scipy.optimize import linprog

from viewgain.arrays import Array, Mask, Vector
from viewgain.parcels._statistics import FEATURES, QUANTITIES

LEVELS = (0.05, 0.5, 0.95)
"""Which quantiles: the ends of a 90 % interval, and the value reported."""


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """How far the truth lies from what is seen."""

    weights: Array
    """(10, 3, 8): for each quantity and level the weight of each feature."""

    def quantiles(self, features: Array) -> Array:
        """Return the (10, 3) factors from seen value to low end, value and high end, in ascending order.

        Args:
            features: (10, 8) features of each quantity.
        """
        return np.sort(np.exp(np.einsum("qlf,qf->ql", self.weights, features)), axis=1)

    def to_json(self, about: str) -> str:
        """Return the text of a calibration file."""
        rows = [
            f'    "{name}": {json.dumps([[round(float(w), 5) for w in level] for level in weights])}'
            for name, weights in zip(QUANTITIES, self.weights, strict=True)
        ]
        head = f'{{\n  "about": {json.dumps(about)},\n  "features": {json.dumps(FEATURES)},\n  "levels": {json.dumps(LEVELS)},\n'
        return head + '  "weights": {\n' + ",\n".join(rows) + "\n  }\n}\n"


@cache
def calibration() -> Calibration:
    """Return the calibration that comes with the package."""
    text = (resources.files("viewgain.parcels") / "calibration.json").read_text(encoding="utf-8")
    weights = json.loads(text)["weights"]
    return Calibration(np.array([weights[name] for name in QUANTITIES], dtype=float))


def calibrated(features: Array, log_ratio: Array, held_out: Mask) -> Calibration:
    """Return the calibration learnt from scans whose truth is known.

    Args:
        features: (n, 10, 8) features.
        log_ratio: (n, 10) logarithm of true over seen value.
        held_out: (n,) scans for the conformal step; the quantiles are fitted to the others.
    """
    weights = np.zeros((len(QUANTITIES), len(LEVELS), len(FEATURES)))
    for quantity in range(len(QUANTITIES)):
        x, y = features[:, quantity], log_ratio[:, quantity]
        for k, level in enumerate(LEVELS):
            weights[quantity, k] = quantile_regression(x[~held_out], y[~held_out], level)
            if level != 0.5:
                left = y[held_out] - x[held_out] @ weights[quantity, k]
                weights[quantity, k, 0] += conformal_shift(left, level)
    return Calibration(weights)


def quantile_regression(x: Array, y: Vector, level: float) -> Vector:
    """Return the (k,) weights w that minimise the pinball loss of y - x w at a level: a linear program.

    Args:
        x: (n, k) features.
        y: (n,) values.
        level: Between 0 and 1.
    """
    count, width = x.shape
    cost = np.concatenate([np.zeros(width), np.full(count, level), np.full(count, 1 - level)])
    unit = np.eye(count)
    bounds = [(None, None)] * width + [(0, None)] * (2 * count)
    found = linprog(cost, A_eq=np.hstack([x, unit, -unit]), b_eq=y, bounds=bounds, method="highs")
    return np.asarray(found.x[:width])


def conformal_shift(left: Vector, level: float) -> float:
    """Return by how much a quantile must move so that its share of held-out scans lies beyond, corrected for their number.

    Args:
        left: (n,) held-out values less their predicted quantile.
        level: Which quantile; below one half the shift never moves it up, above never down past what is needed.
    """
    count = len(left)
    outside = min(level, 1 - level)
    rank = outside * (count + 1)
    share = max(rank - 1, 0) / max(count - 1, 1)
    return float(np.quantile(left, share if level < 0.5 else 1 - share))

"""Logistic regression: the weights that make what was found likeliest, held back by a little L2."""

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from viewgain.arrays import Array, Vector


def logistic(inputs: Array, found: Vector, ridge: float) -> tuple[Vector, float]:
    """Return (F,) weights and the bias that minimise -log likelihood + ridge / 2 |weights|^2; the bias is free.

    Args:
        inputs: (n, F) numbers, scaled.
        found: (n,) what came of each, 0 to 1.
        ridge: Over 0, so that there is one answer even where the inputs tell all apart.
    """
    table = np.column_stack([inputs, np.ones(len(inputs))])
    held = np.append(np.full(inputs.shape[1], ridge), 0.0)

    def cost(weights: Vector) -> tuple[float, Vector]:
        odds = table @ weights
        likely = np.sum(np.logaddexp(0, odds) - found * odds)
        return float(likely + held @ weights**2 / 2), table.T @ (expit(odds) - found) + held * weights

    best = minimize(cost, np.zeros(table.shape[1]), jac=True, method="BFGS", options={"gtol": 1e-7 * max(len(found), 1)}).x
    return best[:-1], float(best[-1])

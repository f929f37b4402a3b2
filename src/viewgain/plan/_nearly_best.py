"""How likely no other candidate is better by two points of volume error, where log-odds of errors are normal (ours).

What speaks for a choice is in one number: a small error of its own, a gap to the next, and few that could turn out better. Many
candidates that nearly tie make a choice safe where their errors are small, and doubtful where they are not.
"""

import numpy as np
from scipy.special import expit, logit, ndtr, ndtri

from viewgain.arrays import Mask, Vector
from viewgain.errors import ConfigError

NEARLY = 0.02
"""A view whose expected error is at most so much above the least counts as nearly best: two points of relative error."""
SCATTER = 1.0
"""Standard deviation of the log-odds of what a view is worth around what is expected of it; the fit of
:mod:`viewgain.plan._confidence` makes up for a wrong one."""
LEAST = 1e-3
"""Expected errors count as within this and 1 minus this."""
NODES = 400
"""Points of the midpoint rule; the integrand falls from 1 to 0 at most, so its error is at most 1 / (2 nodes)."""


def chance_of_nearly_best(errors: Vector, allowed: Mask, chosen: int) -> float:
    """Return the chance that a candidate's worth is within :data:`NEARLY` of the best, 0 to 1; 1 where nothing else is allowed.

    P = integral over u from 0 to 1 of the product over the others j of P(e_j >= e(u) - NEARLY), where e(u) is the u-quantile of
    the chosen one's error and logit e_j is normal around logit of its expectation.

    Args:
        errors: (V,) expected relative volume errors; not NaN where allowed.
        allowed: (V,) candidates that count.
        chosen: One of them.

    Raises:
        ConfigError: If the chosen one is not allowed, or an allowed one has no error.
    """
    if not allowed[chosen] or np.any(np.isnan(errors[allowed])):
        raise ConfigError(f"nearly best: got candidate {chosen} among errors {errors} with {allowed} allowed, wanted one of them")
    odds = logit(np.clip(errors, LEAST, 1 - LEAST))
    others = np.flatnonzero(allowed & (np.arange(len(errors)) != chosen))
    reached = expit(odds[chosen] + SCATTER * ndtri((np.arange(NODES) + 0.5) / NODES)) - NEARLY
    bound = np.where(reached > 0, logit(np.maximum(reached, 1e-12)), -np.inf)  # (n,)
    return float(ndtr((odds[others] - bound[:, None]) / SCATTER).prod(axis=1).mean())

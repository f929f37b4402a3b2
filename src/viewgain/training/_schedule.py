"""The learning rate at every step."""

import math

from viewgain.training._settings import TrainingSettings


def learning_rate(settings: TrainingSettings, step: int, *, clock: float = 0.0) -> float:
    """Return the rate of the step after ``step`` finished ones.

    Args:
        settings: The recipe's table.
        step: Finished steps.
        clock: Share of the time limit that is over, in [0, 1]; 0 where there is no limit. Only ``cosine_clock`` looks at it.
    """
    rise = min(1.0, (step + 1) / settings.warm_up) if settings.warm_up else 1.0
    done = step / settings.iterations
    if settings.schedule == "steps":
        fall = settings.decay ** (step // settings.decay_every)
    elif settings.schedule == "constant":
        fall = 1.0
    else:
        fall = _half_cosine(max(done, clock) if settings.schedule == "cosine_clock" else done)
    return settings.learning_rate * rise * fall


def _half_cosine(done: float) -> float:
    return 0.5 * (1 + math.cos(math.pi * min(1.0, done)))

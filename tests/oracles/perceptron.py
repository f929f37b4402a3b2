"""The error model number by number."""

import math

from viewgain.arrays import Vector
from viewgain.plan import MOST_SHIFT, WITHIN, ErrorModel, Outcome


def corrected_slowly(model: ErrorModel, guess: Outcome, circumstances: Vector) -> tuple[float, float]:
    """Return the chance of no volume and how far off one is, perceptron by perceptron, cell by cell."""
    missed = min(max(guess.missed, 1e-4), 1 - 1e-4)
    odds, size = math.log(missed) - math.log1p(-missed), math.log(max(guess.off, 1e-4))
    numbers = [*circumstances.tolist(), odds, size]
    scaled = [
        min(max((number - mean) / scale, -WITHIN), WITHIN)
        for number, mean, scale in zip(numbers, model.mean.tolist(), model.scale.tolist(), strict=True)
    ]
    members = len(model.layers[0][1])
    totals = [0.0, 0.0]
    for member in range(members):
        values = scaled
        for depth, (weights, bias) in enumerate(model.layers):
            outputs = []
            for row, shift in zip(weights[member].tolist(), bias[member].tolist(), strict=True):
                total = shift + sum(weight * value for weight, value in zip(row, values, strict=True))
                outputs.append(total if depth == len(model.layers) - 1 else math.tanh(total))
            values = outputs
        totals = [total + value / members for total, value in zip(totals, values, strict=True)]
    moved = [MOST_SHIFT * math.tanh(total / MOST_SHIFT) for total in totals]
    return 1 / (1 + math.exp(-odds - moved[0])), min(math.exp(size + moved[1]), 1.0)

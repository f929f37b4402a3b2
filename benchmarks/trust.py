"""How much say the model should have beside a network, by what measuring the present scan left open.

The boxes are those of ``error-model --kept FOLDER``, one measured scan of each position: the weights of
:func:`viewgain.plan.trust` are chosen by what came of the position that each weight names.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks._error_fit import fitted, runs_of
from benchmarks._measured_boxes import DrawnBox, MeasuredBox, drawn_box, measured_boxes, stream_of
from benchmarks._tables import bootstrap, markdown
from benchmarks.error_model import BOXES
from viewgain.arrays import Vector
from viewgain.evaluation._volume_confidence import ASKED
from viewgain.gain import believed_scan, costs
from viewgain.geometry import inverse
from viewgain.inference import VOLUME_MODEL, PoseScorer
from viewgain.measure import measure
from viewgain.plan import Belief, ErrorModel, believe, expected_error
from viewgain.plan._volume_network import ALONE, NOTHING_MEASURED

WEIGHTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Of the model."""
SPARE = 7
"""Number of the scan to decide by: none of those that were measured."""
_PRESENT = 0x7072
"""Stream of present positions."""
STATES = ("every dimension bounded", "one or more open", "not a box, guessed")
"""What measuring the present scan left."""
SHIPPED = dict(zip(STATES, (*ALONE, NOTHING_MEASURED), strict=True))
"""Weight of the model in each, as the package has it."""
_WORDS = """One scan of each position was measured, a miss counts as 100 %. Mean outcome, %, at the position that a weight of the
model names (0: the network alone), and the difference to the weight that is shipped with its 95 % interval, boxes drawn anew. The
learned part of the model was fitted to the other half of the boxes."""


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """What model and network say of one box's positions."""

    state: str
    """What is known of the box."""
    network: str
    """Which network."""
    found: Vector
    """(V,) outcome of the scan that was measured from each position."""
    model: Vector
    """(V,) expected errors by the model."""
    by_network: Vector
    """(V,) the same by the network."""

    def at_choice(self, weight: float) -> float:
        """Return the outcome at the position that the weighted mean names."""
        return float(self.found[np.argmin(weight * self.model + (1 - weight) * self.by_network)])


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    boxes = list(measured_boxes(options.scenes or BOXES, options.kept, options.workers))
    other_half = [fitted(runs_of([each for each in boxes if each.number % 2 != half])) for half in (0, 1)]
    scorers = {name: PoseScorer.load(name) for name in (ASKED[False], VOLUME_MODEL)}
    asked = [each for measured in boxes for each in _asked(measured, other_half[measured.number % 2], scorers)]
    print("## Weights of model and network\n")
    print(f"{len(boxes)} boxes. {_WORDS}\n")
    header = ("what is known", "network", "boxes", *(f"{weight:g}" for weight in WEIGHTS), "best run", "any position")
    rows = []
    for state in STATES:
        for network in scorers:
            own_rows = [each for each in asked if (each.state, each.network) == (state, network)]
            if own_rows:
                rows.append((state, network, str(len(own_rows)), *_cells(own_rows)))
    print(markdown(header, rows) + "\n")


def _asked(measured: MeasuredBox, model: ErrorModel, scorers: dict[str, PoseScorer]) -> Iterator[Asked]:
    """Yield what is said of a box by each network that knows such rigs; nothing where the model has no opinion."""
    drawn = drawn_box(stream_of(measured.number))
    assert drawn is not None
    views = np.array(sorted(measured.alone))
    present = int(np.random.default_rng([_PRESENT, measured.number]).choice(views))
    scan = believed_scan(drawn.scans, present, SPARE, (0.0, 0.0))
    if scan is None or scan.camera_to_world is None:
        return
    belief = believe(measure(scan, camera=drawn.camera), drawn.camera)
    if belief is None:
        return
    candidates = inverse(scan.camera_to_world) @ drawn.stations[views]
    expected = np.array([[expected_error(box, candidate, drawn.camera, belief.noise, model) for candidate in candidates]
                         for box in belief.boxes]).mean(axis=0)  # fmt: skip
    found = costs([measured.alone[view] for view in views.tolist()])
    for name in _knowing(drawn, scorers):
        yield Asked(_state(belief), name, found, expected, -scorers[name].assessed(scan.points, candidates).scores)


def _knowing(drawn: DrawnBox, scorers: dict[str, PoseScorer]) -> list[str]:
    """Return the networks that were trained on such positions."""
    return [name for name in scorers if name == VOLUME_MODEL or drawn.rig == "irregular4"]


def _state(belief: Belief) -> str:
    if belief.guessed:
        return STATES[2]
    return STATES[0] if belief.bounded else STATES[1]


def _cells(asked: list[Asked]) -> Iterator[str]:
    """Yield a cell for each weight, then the outcome of the best run and of any."""
    shipped = np.array([each.at_choice(SHIPPED[each.state]) for each in asked])
    for weight in WEIGHTS:
        chosen = np.array([each.at_choice(weight) for each in asked])
        yield _mean(chosen) + ("" if weight == SHIPPED[asked[0].state] else f"; {_difference(chosen - shipped)}")
    yield _mean(np.array([each.found.min() for each in asked]))
    yield _mean(np.array([each.found.mean() for each in asked]))


def _mean(values: Vector) -> str:
    return f"{100 * float(values.mean()):.2f}"


def _difference(values: Vector) -> str:
    low, high = bootstrap(values)
    return f"{100 * float(values.mean()):+.2f} ({100 * low:+.2f} to {100 * high:+.2f})"

"""``viewgain next``: rank the candidate views and say in words where to go."""

import json
import sys

from viewgain.cli._commands import Next
from viewgain.cli._exit import NOTHING_MEASURED
from viewgain.cli._files import check, read_floor, read_one
from viewgain.cli._text import decision_in_words, measurement_table, ranking_table, to_stdout
from viewgain.measure import REASONS, fuse, measure
from viewgain.plan import next_view


def run_next(command: Next) -> int:
    """Plan and print; exit code 3 if there is nothing to plan for."""
    check(command.scans, command.reading)
    scans = [read_one(path, index, command.reading) for index, path in enumerate(command.scans)]
    camera, floor = command.reading.camera, read_floor(command.reading)
    current = measure(scans[0], camera=camera, floor=floor) if len(scans) == 1 else fuse(scans, camera=camera, floor=floor)
    plan = next_view(
        current,
        command.rig,
        objective=command.objective,
        camera=camera,
        tolerance=command.tolerance,
        confidence=command.confidence,
    )
    if command.json:
        print(json.dumps(plan.to_dict(), allow_nan=False))
        return 0 if plan.candidates else NOTHING_MEASURED
    for note in current.notes:
        print(f"viewgain: note: {note}", file=sys.stderr)
    to_stdout(measurement_table(current))
    if not plan.candidates:
        print(f"viewgain: {plan.reason}: {REASONS.get(plan.reason or '', 'no candidate view')}", file=sys.stderr)
        return NOTHING_MEASURED
    to_stdout(ranking_table(plan))
    print(decision_in_words(plan))
    return 0

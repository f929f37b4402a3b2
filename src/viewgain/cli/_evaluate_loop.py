"""``viewgain evaluate loop``: planners in the closed loop on fresh boxes, beside floors and whoever knows the truth."""

import json

from viewgain.cli._finish import finish
from viewgain.cli._fresh_boxes import boxes_bar, require_two
from viewgain.cli._volume_commands import EvaluateLoop
from viewgain.evaluation import LoopSettings, VolumeSettings, check_loop_policies, loop_boxes, loop_markdown, loop_table
from viewgain.report import write_loop_picture


def run_evaluate_loop(command: EvaluateLoop) -> int:
    """Print the table."""
    require_two(command, "loop")
    check_loop_policies(command.policies)
    boxes = VolumeSettings(
        seed=command.seed,
        rig=command.rig,
        camera=command.camera,
        fused=True,
        side=command.side,
        distance=command.distance,
        elevation_deg=command.elevation,
    )
    settings = LoopSettings(
        boxes=boxes, most_views=command.most_views, tolerance=command.tolerance, confidence=command.confidence
    )
    with boxes_bar() as watch:
        plays = loop_boxes(settings, command.boxes, command.policies, workers=command.workers, folder=command.out, watch=watch)
    table = loop_table(settings, plays, command.policies)
    has_curves = any(row.errors is not None for row in table.rows)
    finish(
        "loop",
        as_json=json.dumps(table.to_dict(), allow_nan=False) + "\n",
        as_markdown=loop_markdown(table),
        prints_json=command.json,
        out=command.out,
        draw=(lambda path: write_loop_picture(table, path)) if has_curves else None,
    )
    return 0

"""``viewgain evaluate shapes``: planners of a second view on objects of any shape, beside floors and oracle."""

import json

from viewgain.cli._finish import finish
from viewgain.cli._fresh_boxes import boxes_bar
from viewgain.cli._volume_commands import EvaluateShapes
from viewgain.errors import ConfigError
from viewgain.evaluation import (
    SHAPE_POLICIES,
    ShapeSettings,
    check_shape_policies,
    run_shapes,
    shape_markdown,
    shape_table,
)


def run_evaluate_shapes(command: EvaluateShapes) -> int:
    """Print the table."""
    if command.objects < 2:
        raise ConfigError(f"evaluate shapes: got {command.objects} objects, wanted 2 or more")
    policies = command.policies or SHAPE_POLICIES
    check_shape_policies(policies)
    settings = ShapeSettings(
        seed=command.seed,
        categories=command.categories,
        meshes=command.meshes,
        size=command.size,
        rig=command.rig,
        camera=command.camera,
        captures=command.captures,
        distance=command.distance,
        elevation_deg=command.elevation,
    )
    with boxes_bar("objects") as watch:
        runs = run_shapes(settings, command.objects, policies, workers=command.workers, folder=command.out, watch=watch)
    table = shape_table(runs, settings, policies)
    finish(
        "shapes",
        as_json=json.dumps(table.to_dict(), allow_nan=False) + "\n",
        as_markdown=shape_markdown(table),
        prints_json=command.json,
        out=command.out,
    )
    return 0

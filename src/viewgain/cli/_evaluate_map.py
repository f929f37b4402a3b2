"""``viewgain evaluate map``: what every position around one fresh box is worth, and what policies believe."""

import json

from viewgain.cli._finish import finish
from viewgain.cli._fresh_boxes import boxes_alone
from viewgain.cli._volume_commands import EvaluateMap
from viewgain.evaluation import gain_map, gain_map_markdown
from viewgain.report import write_map_picture


def run_evaluate_map(command: EvaluateMap) -> int:
    """Print the table, and write it and the picture where a folder is named."""
    drawn = gain_map(boxes_alone(command), command.box, command.policies)
    finish(
        "map",
        as_json=json.dumps(drawn.to_dict(), allow_nan=False) + "\n",
        as_markdown=gain_map_markdown(drawn),
        prints_json=command.json,
        out=command.out,
        draw=lambda path: write_map_picture(drawn, path),
    )
    return 0

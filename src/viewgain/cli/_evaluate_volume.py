"""``viewgain evaluate volume``: planners on fresh boxes, beside floors, ceiling and oracle."""

import json
from pathlib import Path

from viewgain.cli._finish import finish
from viewgain.cli._fresh_boxes import boxes_alone, boxes_bar, require_two
from viewgain.cli._volume_commands import EvaluateVolume
from viewgain.errors import ConfigError
from viewgain.evaluation import (
    VolumeRow,
    VolumeTable,
    boxes_in_words,
    check_volume_policies,
    run_boxes,
    volume_markdown,
    volume_table,
)
from viewgain.report import write_confidence_picture


def run_evaluate_volume(command: EvaluateVolume) -> int:
    """Print the table."""
    require_two(command, "volume")
    if command.first < 0:
        raise ConfigError(f"evaluate volume: got first box {command.first}, wanted 0 or more")
    check_volume_policies(command.policies)
    settings = boxes_alone(command)
    with boxes_bar() as watch:
        runs = run_boxes(
            settings,
            command.boxes,
            command.policies,
            first=command.first,
            workers=command.workers,
            folder=command.out,
            watch=watch,
        )
    table = volume_table(settings, runs, command.policies)
    first = next((row for row in table.rows if row.sure is not None), None)
    finish(
        "volume",
        as_json=json.dumps(table.to_dict(), allow_nan=False) + "\n",
        as_markdown=volume_markdown(table),
        prints_json=command.json,
        out=command.out,
        draw=None if first is None else lambda path: _draw(first, table, path),
    )
    return 0


def _draw(row: VolumeRow, table: VolumeTable, path: Path) -> None:
    asked = table.settings
    who = f"{row.name}, {boxes_in_words(table)}, rig {asked.rig}, camera {asked.camera}"
    assert row.sure is not None
    write_confidence_picture(row.sure, who, path)

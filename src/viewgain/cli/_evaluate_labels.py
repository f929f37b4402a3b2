"""``viewgain evaluate labels``: which positions labels choose, and what is measured from there."""

import json

from viewgain.cli._finish import finish
from viewgain.cli._volume_commands import EvaluateLabels
from viewgain.datasets import Dataset
from viewgain.evaluation import label_table, labels_markdown


def run_evaluate_labels(command: EvaluateLabels) -> int:
    """Print the table."""
    table = label_table(Dataset(command.data), command.targets, estimator=command.estimator, seed=command.seed)
    finish(
        "labels",
        as_json=json.dumps(table.to_dict(), allow_nan=False) + "\n",
        as_markdown=labels_markdown(table),
        prints_json=command.json,
        out=command.out,
    )
    return 0

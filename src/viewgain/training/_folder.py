"""The folder of a run: what was asked for, by which versions, the metrics line by line, checkpoints and the best weights."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from viewgain.datasets import make_folder, write_whole
from viewgain.errors import StorageError, TrainingError
from viewgain.training._recipe_file import training_recipe_from_table
from viewgain.training._settings import TrainingRecipe

RUN, METRICS, CHECKPOINTS, BEST, DATA = "run.json", "metrics.jsonl", "checkpoints", "best.safetensors", "data"
"""Names in the folder."""
SCHEMA = 1
"""Version of run.json."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRecord:
    """What run.json says."""

    recipe: TrainingRecipe
    """The whole recipe, every default written out."""
    data: str
    """Folder of the data set when the run was started."""
    plan: str
    """Digest of what the data set is; a run goes on only with the same."""
    facts: Mapping[str, Any]
    """Versions, git revision, device, numbers of samples and objects, when it began: for people, and for the model card."""


class RunFolder:
    """Paths of a run, and its metrics."""

    def __init__(self, path: Path) -> None:
        """Name a folder; nothing is made yet."""
        self.path = path

    @property
    def checkpoints(self) -> Path:
        """Folder of the checkpoints."""
        return self.path / CHECKPOINTS

    @property
    def best(self) -> Path:
        """The weights that were best on the validation objects."""
        return self.path / BEST

    def claim(self) -> None:
        """Make the folder.

        Raises:
            TrainingError: If it holds a run already.
            StorageError: If it cannot be made.
        """
        if (self.path / RUN).exists():
            raise TrainingError(f"{self.path}: holds a run already; go on with it by --resume, or name another folder")
        make_folder(self.checkpoints)

    def write(self, record: RunRecord) -> None:
        """Write run.json."""
        table = {
            "schema": SCHEMA,
            "recipe": recipe_to_table(record.recipe),
            "data": record.data,
            "plan": record.plan,
            "facts": dict(record.facts),
        }
        write_whole(self.path / RUN, (json.dumps(table, indent=1) + "\n").encode())

    def read(self) -> RunRecord:
        """Return what run.json says.

        Raises:
            TrainingError: If there is no run in the folder, or its run.json is damaged or of a later version.
        """
        path = self.path / RUN
        try:
            table = json.loads(path.read_text(encoding="utf-8"))
            if table["schema"] != SCHEMA:
                raise TrainingError(f"{path}: got schema {table['schema']!r}, wanted {SCHEMA}; use the version that wrote it")
            recipe = training_recipe_from_table(
                {k: v for k, v in table["recipe"].items() if k != "name"}, table["recipe"]["name"]
            )
            return RunRecord(recipe=recipe, data=table["data"], plan=table["plan"], facts=table["facts"])
        except FileNotFoundError:
            raise TrainingError(f"{self.path}: holds no run; name the folder that viewgain train wrote") from None
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            if isinstance(error, TrainingError):
                raise
            raise TrainingError(f"{path}: cannot be read as a run ({error})") from error

    def append(self, line: Mapping[str, Any]) -> None:
        """Add one line of metrics.

        Raises:
            StorageError: If it cannot be written.
        """
        try:
            with (self.path / METRICS).open("a", encoding="utf-8") as file:
                file.write(json.dumps(dict(line)) + "\n")
        except OSError as error:
            raise StorageError(
                f"{self.path / METRICS}: cannot be written ({error.strerror}); make room, then --resume"
            ) from error

    def metrics(self) -> list[dict[str, Any]]:
        """Return the lines of metrics; a last one that was cut short is left out, and there are none before the first step."""
        try:
            lines = (self.path / METRICS).read_text(encoding="utf-8").splitlines()
        except FileNotFoundError:
            return []
        return [line for line in map(_line, lines) if line is not None]

    def cut_metrics(self, step: int) -> None:
        """Take away the lines after a step: that is where the run goes on."""
        kept = [json.dumps(line) + "\n" for line in self.metrics() if line["step"] <= step]
        write_whole(self.path / METRICS, "".join(kept).encode())


def recipe_to_table(recipe: TrainingRecipe) -> dict[str, Any]:
    """Return a recipe as a table of its file, every default written out."""
    table: dict[str, Any] = json.loads(json.dumps(asdict(recipe)))
    return table


def _line(text: str) -> dict[str, Any] | None:
    try:
        line = json.loads(text)
    except ValueError:
        return None
    return line if isinstance(line, dict) and isinstance(line.get("step"), int) else None

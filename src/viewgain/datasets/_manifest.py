"""The manifest of a data set: typed JSON, written last, so that a folder with one is complete."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from viewgain.datasets._columns import Tables
from viewgain.datasets._plan import SCHEMA
from viewgain.datasets._recipe_file import record
from viewgain.datasets._sample import Frame
from viewgain.datasets._unit import Skipped
from viewgain.errors import ConfigError, DataError

MANIFEST = "manifest.json"
"""Its file in the data set's folder."""
RECIPE = "recipe.json"
"""What is being built; written first."""
SHARDS = "shards"
"""Folder of the shards."""
ERRORS = "errors"
"""Folder of the volume errors, one folder per estimator."""
ORDER = "present view first: entry k is candidate (view + k) mod V of the rig"
"""The order of everything that belongs to candidates."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardEntry:
    """One shard file."""

    name: str
    """File name in ``shards/``."""
    sha256: str
    """Of the whole file."""
    bytes: int
    samples: int
    points: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Manifest:
    """What a data set holds."""

    schema: int = SCHEMA
    """Version of the layout."""
    viewgain: str
    """Version of the package that built it."""
    recipe: dict[str, Any]
    """The whole recipe, every default written out."""
    plan: str
    """SHA-256 of recipe.json's content."""
    frame: Frame
    """Frame of the points."""
    order: str = ORDER
    """Order of the candidates."""
    tables: Tables
    """Words that the columns count."""
    targets: tuple[str, ...]
    """Scores stored with every sample."""
    objects: tuple[str, ...]
    """Name of each object, by its number."""
    shards: tuple[ShardEntry, ...]
    """In order."""
    skipped: tuple[Skipped, ...] = field(default=())
    """What could not be made, and why."""

    @property
    def samples(self) -> int:
        """Number of samples."""
        return sum(shard.samples for shard in self.shards)

    @property
    def points(self) -> int:
        """Number of points."""
        return sum(shard.points for shard in self.shards)

    @property
    def bytes(self) -> int:
        """Size of all shards."""
        return sum(shard.bytes for shard in self.shards)

    def to_json(self) -> str:
        """Return the text of manifest.json."""
        return json.dumps(asdict(self), indent=1, sort_keys=True) + "\n"


def read_manifest(folder: Path) -> Manifest:
    """Return the manifest of a data set.

    Raises:
        DataError: If there is none (nothing there, or not finished), or it is damaged or of a later version.
    """
    path = folder / MANIFEST
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        begun = (folder / RECIPE).exists()
        raise DataError(f"{folder}: {'is not finished; run its build with --resume' if begun else 'holds no data set'}") from None
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: cannot be read ({error}); run its build with --resume") from error
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        found = content.get("schema") if isinstance(content, dict) else content
        raise DataError(f"{path}: got schema {found!r}, wanted {SCHEMA}; this version of viewgain reads no other")
    try:
        return record(Manifest, content, str(path))
    except ConfigError as error:
        raise DataError(f"{error}; the manifest is damaged") from error

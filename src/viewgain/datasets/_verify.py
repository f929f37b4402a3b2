"""Checking every byte of a data set, and telling what it holds."""

import hashlib
import json
from pathlib import Path

from viewgain.datasets._files import sha256_of
from viewgain.datasets._manifest import ERRORS, RECIPE, SHARDS, read_manifest
from viewgain.datasets._tensors import intact, opened


def verify(folder: Path) -> list[str]:
    """Return what is wrong with a data set, one line per file; empty if every file holds what was written.

    What is found is made anew by ``viewgain dataset build`` with ``--resume`` (and ``--errors``).

    Raises:
        DataError: If there is no finished data set in the folder.
    """
    manifest = read_manifest(folder)
    problems = []
    try:
        digest = hashlib.sha256(json.dumps(json.loads((folder / RECIPE).read_text()), sort_keys=True).encode()).hexdigest()
    except (OSError, ValueError):
        digest = ""
    if digest != manifest.plan:
        problems.append(f"{RECIPE}: is not the recipe that the manifest was made for")
    for entry in manifest.shards:
        path = folder / SHARDS / entry.name
        if not path.exists():
            problems.append(f"{SHARDS}/{entry.name}: is missing")
        elif path.stat().st_size != entry.bytes:
            problems.append(f"{SHARDS}/{entry.name}: has {path.stat().st_size} bytes, wanted {entry.bytes}")
        elif sha256_of(path) != entry.sha256:
            problems.append(f"{SHARDS}/{entry.name}: its content is not what was written (SHA-256)")
    names = {entry.name: entry.sha256 for entry in manifest.shards}
    for path in sorted((folder / ERRORS).glob("*/*.safetensors")):
        if not intact(path) or opened(path)[1].get("shard_sha256") != names.get(path.name):
            problems.append(f"{path.relative_to(folder)}: is damaged or of another data set")
    return problems


def estimators_of(folder: Path) -> dict[str, int]:
    """Return the estimators whose volume errors lie beside a data set, and for how many shards."""
    return {path.name: len(list(path.glob("*.safetensors"))) for path in sorted((folder / ERRORS).glob("*")) if path.is_dir()}

"""Writing into a report folder: every file appears whole or not at all."""

import json
import os
import secrets
from pathlib import Path

from viewgain.errors import StorageError


def make_folder(folder: Path) -> None:
    """Create a folder and its parents; one that exists is kept.

    Raises:
        StorageError: If it cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _cannot_write(folder, error) from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file beside its place and move it there, so that a reader never meets half of it.

    Raises:
        StorageError: If the folder is missing, full or not writable; nothing is left behind.
    """
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        try:
            temporary.write_bytes(content)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise _cannot_write(path, error) from error


def to_json(content: object) -> bytes:
    """Return the JSON text of ``content``; a number that is not finite is a bug and raises."""
    return (json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _cannot_write(path: Path, error: OSError) -> StorageError:
    reason = error.strerror or type(error).__name__
    text = f"{os.fspath(path)}: cannot be written ({reason}); check the folder and its free space"
    return StorageError("".join(sign if sign.isprintable() else "?" for sign in text))

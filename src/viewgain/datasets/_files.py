"""Writing into a data set's folder: whole files or none, and one kind of error."""

import hashlib
from pathlib import Path

from viewgain.errors import ScanError, StorageError
from viewgain.scans import write_files


def write_whole(path: Path, content: bytes) -> None:
    """Write one file: a temporary one beside it, then a rename.

    Raises:
        StorageError: If it cannot be written; nothing of it is left behind.
    """
    try:
        write_files({path: content})
    except ScanError as error:
        raise StorageError(str(error)) from error


def make_folder(path: Path) -> None:
    """Make a folder and its parents, if they are not there.

    Raises:
        StorageError: If it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"{path}: cannot be made ({error.strerror}); name a folder that can be written") from error


def remove_unfinished(folder: Path) -> None:
    """Remove temporary files that a killed build left behind."""
    for path in folder.glob(".*.tmp"):
        path.unlink(missing_ok=True)


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()

"""A folder of results that are costly and kept belongs to one question: asked another, it is refused."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from viewgain.datasets import make_folder, write_whole
from viewgain.errors import DataError

SETTINGS = "settings.json"
"""File that says which question the results beside it answer."""


def claim(folder: Path, question: Mapping[str, Any], *, results: Path | None = None) -> None:
    """Make a folder of results, or make sure that those in it answer the same question, by the same version.

    Args:
        folder: Where :data:`SETTINGS` lies.
        question: All that the results depend on, as plain values for JSON.
        results: Folder of the results; None for the same one. Made if it is missing.

    Raises:
        DataError: If there are results of another question, or of one that nobody knows.
        StorageError: If the folder cannot be written.
    """
    from viewgain import __version__

    kept = folder if results is None else results
    make_folder(kept)
    file, text = folder / SETTINGS, json.dumps({"viewgain": __version__, **question}, sort_keys=True) + "\n"
    try:
        found = file.read_bytes() if file.exists() else None
        is_empty = all(each.name.startswith(".") for each in kept.iterdir())
    except OSError as error:
        raise DataError(f"{folder}: cannot be read ({error.strerror}); name another folder") from error
    if found is None and not is_empty:
        raise DataError(f"{kept}: holds results without their {SETTINGS}, of settings that nobody knows; name another folder")
    if found not in (None, text.encode()):
        raise DataError(f"{folder}: holds results of other settings; name another folder, or ask as its {SETTINGS} does")
    if found is None:
        write_whole(file, text.encode())


def kept_text(file: Path) -> str | None:
    """Return what a file of results says; None if there is none.

    Raises:
        DataError: If it cannot be read, or is no UTF-8 text.
    """
    try:
        return file.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise damaged(file) from error


def damaged(file: Path) -> DataError:
    """Return the error about a file of results that makes no sense."""
    return DataError(f"{file}: is damaged; remove it and run the same command again")

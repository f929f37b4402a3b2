"""The end of a command that judges: its answer is printed and, where a folder is named, written there."""

from collections.abc import Callable
from pathlib import Path

from viewgain.cli._judging import note
from viewgain.datasets import make_folder, write_whole
from viewgain.errors import MissingExtraError


def finish(name: str, *, out: Path | None, json: bool, as_json: str, as_markdown: str, draw: Callable[[Path], object]) -> None:
    """Print an answer, and write ``name``.json, .md and .png where a folder is named.

    Raises:
        StorageError: If it cannot be written.
        ConfigError: If the picture cannot be.
    """
    print(as_json if json else as_markdown, end="")
    if out is None:
        return
    write_tables(out, name, as_json=as_json, as_markdown=as_markdown)
    write_picture(out / f"{name}.png", draw)


def write_tables(out: Path, name: str, *, as_json: str, as_markdown: str) -> None:
    """Write ``name``.json and .md into a folder, which is made if it is missing.

    Raises:
        StorageError: If they cannot be written.
    """
    make_folder(out)
    write_whole(out / f"{name}.json", as_json.encode())
    write_whole(out / f"{name}.md", as_markdown.encode())


def write_picture(path: Path, draw: Callable[[Path], object]) -> None:
    """Have a picture drawn; without the extra there is none, and a note says so.

    Raises:
        ConfigError: If it cannot be written.
    """
    try:
        draw(path)
    except MissingExtraError as error:
        note(f"no picture: {error}")

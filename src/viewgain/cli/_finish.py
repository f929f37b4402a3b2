"""How every ``viewgain evaluate`` ends: the answer is printed, and written where a folder is named."""

from collections.abc import Callable
from pathlib import Path

from viewgain.cli._judging import note
from viewgain.datasets import make_folder, write_whole
from viewgain.errors import MissingExtraError


def finish(
    name: str,
    *,
    as_json: str,
    as_markdown: str,
    prints_json: bool,
    out: Path | None,
    draw: Callable[[Path], object] | None = None,
) -> None:
    """Print an answer, and write it where a folder is named.

    Args:
        name: Of the files, without ending.
        as_json: The answer for programs.
        as_markdown: The answer for people.
        prints_json: Which of them is printed.
        out: Folder to write both into, made if it is missing; None to write nothing.
        draw: Saves the picture under a path; None where there is none.

    Raises:
        StorageError: If something cannot be written.
    """
    print(as_json if prints_json else as_markdown, end="")
    if out is None:
        return
    make_folder(out)
    write_whole(out / f"{name}.json", as_json.encode())
    write_whole(out / f"{name}.md", as_markdown.encode())
    if draw is not None:
        write_picture(out / f"{name}.png", draw)


def write_picture(path: Path, draw: Callable[[Path], object]) -> None:
    """Have a picture drawn; without the extra there is none, and a note says so.

    Raises:
        StorageError: If it cannot be written.
    """
    try:
        draw(path)
    except MissingExtraError as error:
        note(f"no picture: {error}")

"""The optional dependencies of this room: checked once, named in one line where they are missing."""

from importlib import import_module

from viewgain.errors import MissingExtraError

NEEDED = ("matplotlib", "jinja2")
"""Modules of the extra ``report``."""


def require_extra() -> None:
    """Check that drawing and page writing can be imported.

    Raises:
        MissingExtraError: If matplotlib or jinja2 is not installed.
    """
    try:
        for name in NEEDED:
            import_module(name)
    except ImportError as error:
        raise MissingExtraError('the report needs matplotlib and jinja2: pip install "viewgain[report]"') from error

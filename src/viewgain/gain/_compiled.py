"""Kernels as machine code: the optional extra ``data`` (numba), loaded only where a kernel is first used."""

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any, Literal, TypeAlias

from viewgain.errors import MissingExtraError

Search: TypeAlias = Literal["auto", "numba", "scipy"]
"""How near points are found; "auto" takes numba where it is installed. The answers are equal, bit for bit."""


def uses_numba(search: Search) -> bool:
    """Return whether a search is made by machine code."""
    return search == "numba" or (search == "auto" and find_spec("numba") is not None)


@cache
def compiled(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel as machine code; it is kept on disk where there is a place for it.

    Raises:
        MissingExtraError: If numba is not installed.
    """
    try:
        from numba import njit
    except ImportError as error:
        raise MissingExtraError('this search needs numba: pip install "viewgain[data]", or search with scipy') from error
    options: dict[str, Any] = {"nogil": True, "fastmath": False, "error_model": "numpy"}
    try:
        return njit(cache=True, **options)(kernel)  # type: ignore[no-any-return]  # numba is untyped
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return njit(**options)(kernel)  # type: ignore[no-any-return]  # numba is untyped

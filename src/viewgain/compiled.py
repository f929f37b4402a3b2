"""Kernels as machine code: the optional extra ``data`` (numba), loaded only where a kernel is first used."""

from collections.abc import Callable
from functools import cache
from typing import Any

from viewgain.errors import MissingExtraError


@cache
def compiled(kernel: Callable[..., Any], purpose: str) -> Callable[..., Any]:
    """Return a kernel as machine code; it is kept on disk where there is a place for it.

    Args:
        kernel: A function of numbers, arrays and loops only. Its sums are not reordered, so it rounds as plain Python does.
        purpose: What it is for, as the subject of the error below.

    Raises:
        MissingExtraError: If numba is not installed.
    """
    try:
        from numba import njit
    except ImportError as error:
        raise MissingExtraError(f'{purpose} needs numba: pip install "viewgain[data]"') from error
    options: dict[str, Any] = {"nogil": True, "fastmath": False, "error_model": "numpy"}
    try:
        return njit(cache=True, **options)(kernel)  # type: ignore[no-any-return]  # numba is untyped
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return njit(**options)(kernel)  # type: ignore[no-any-return]  # numba is untyped

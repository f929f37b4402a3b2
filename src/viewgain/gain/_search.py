"""How near points are found: by machine code or by scipy's tree."""

from importlib.util import find_spec
from typing import Literal, TypeAlias

Search: TypeAlias = Literal["auto", "numba", "scipy"]
"""How near points are found; "auto" takes numba where it is installed. The answers are equal, bit for bit."""

SEARCHING = "this search (else search with scipy)"
"""What its kernels are for (viewgain.compiled)."""


def uses_numba(search: Search) -> bool:
    """Return whether a search is made by machine code."""
    return search == "numba" or (search == "auto" and find_spec("numba") is not None)

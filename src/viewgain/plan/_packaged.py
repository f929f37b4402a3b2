"""Small fitted models that come with the package as JSON files beside the code."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from viewgain.errors import ModelError

M = TypeVar("M")


def packaged(file: Path, read: Callable[[dict[str, Any]], M]) -> M:
    """Return the model of a file.

    Args:
        file: Where it is.
        read: Makes the model of the file's content; raises ValueError, KeyError or TypeError if it is none.

    Raises:
        ModelError: If the file is missing or broken.
    """
    try:
        return read(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelError(f"{file}: is missing or broken ({error}); install viewgain anew") from error

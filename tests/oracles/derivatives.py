"""Central differences: the slow twin of every derivative."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.box import PARAMETERS, Box


def along_steps(function: Callable[[Box], Any], box: Box, step: float) -> NDArray[np.float64]:
    """Return (..., 9): the central difference of ``function(box)`` along each direction of :meth:`Box.moved`."""
    columns = []
    for k in range(PARAMETERS):
        move = np.zeros(PARAMETERS)
        move[k] = step
        columns.append((np.asarray(function(box.moved(move))) - np.asarray(function(box.moved(-move)))) / (2 * step))
    return np.stack(columns, axis=-1)

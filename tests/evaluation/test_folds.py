"""Which objects are one box, where boxes are held out."""

from typing import Any, cast

import numpy as np

from viewgain.datasets import Dataset
from viewgain.evaluation import boxes_of


class Columns:
    """As much of a data set as is asked for."""

    def __init__(self, **columns: Any) -> None:
        self._columns = {name: np.array(values) for name, values in columns.items()}

    def column(self, name: str) -> Any:
        return self._columns[name]


def test_objects_of_one_size_are_one_box_and_those_of_unknown_size_are_not() -> None:
    sizes = {0: [0.3, 0.2, 0.1], 1: [0.4, 0.2, 0.1], 2: [0.3, 0.2, 0.1], 3: [np.nan] * 3, 4: [np.nan] * 3}
    objects = [4, 0, 1, 2, 3, 0, 2]
    data = Columns(object=objects, dims=[sizes[number] for number in objects])
    assert boxes_of(cast(Dataset, data)) == [(0, 2), (1,), (3,), (4,)]

"""Names for the arrays that travel through viewgain: the shape is part of the name's definition.

All are float64 unless said; units are metres and radians everywhere inside the package (docs/conventions.md).
"""

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Any float64 array; the docstring of the function gives the shape."""
Vector: TypeAlias = Annotated[NDArray[np.float64], "(n,)"]
Vector3: TypeAlias = Annotated[NDArray[np.float64], "(3,)"]
Points: TypeAlias = Annotated[NDArray[np.float64], "(n, 3)"]
Points2: TypeAlias = Annotated[NDArray[np.float64], "(n, 2)"]
Rotation: TypeAlias = Annotated[NDArray[np.float64], "(3, 3) orthonormal, determinant +1"]
Pose: TypeAlias = Annotated[NDArray[np.float64], "(4, 4) rigid motion, a_to_b maps a's coordinates to b's"]
Poses: TypeAlias = Annotated[NDArray[np.float64], "(k, 4, 4) rigid motions"]
Image: TypeAlias = Annotated[NDArray[np.float64], "(h, w)"]
Mask: TypeAlias = Annotated[NDArray[np.bool_], "(n,) or (h, w)"]
Indices: TypeAlias = Annotated[NDArray[np.intp], "(n,)"]
Faces: TypeAlias = Annotated[NDArray[np.int32], "(f, 3) indices of vertices"]
Ids: TypeAlias = Annotated[NDArray[np.int32], "(n,)"]

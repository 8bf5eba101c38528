"""Names for the arrays that travel through the house; shapes are in the comments.

Every array of lengths is in millimetres unless its name has another unit.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Points: TypeAlias = NDArray[np.float64]  # (n, 3)
Points2: TypeAlias = NDArray[np.float64]  # (n, 2)
Directions: TypeAlias = NDArray[np.float64]  # (n, 3), unit length
Directions2: TypeAlias = NDArray[np.float64]  # (n, 2), unit length
Triangles: TypeAlias = NDArray[np.float64]  # (n, 3, 3): patch, vertex, coordinate
Quaternions: TypeAlias = NDArray[np.float64]  # (n, 4), w x y z, unit length
Scalars: TypeAlias = NDArray[np.float64]  # (n,)
Indices: TypeAlias = NDArray[np.int64]  # (n,)

"""Flow in the gap of one package class, per pascal on each edge segment."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points2


@dataclass(frozen=True, slots=True, eq=False)
class GapField:
    """Depth-averaged flow in a gap whose height is ``height_m`` everywhere, linear in the eight edge pressures. SI.

    The mean velocity of a liquid of viscosity mu is ``einsum("sd,sck->dck", p, velocity) / mu`` for pressures p (8, d);
    the wall shear is ``6 |velocity| / height`` of the same sum, whatever the viscosity.
    """

    height_m: float
    length_m: float
    """Along x."""
    width_m: float
    shape: tuple[int, int]
    """(rows along y, columns along x) of the grid."""
    cells: Indices
    """(c,) flat indices, row by row, of the cells in which liquid can flow."""
    centres: Points2
    """(c, 2) in the frame of the underside."""
    pressure: NDArray[np.float32]
    """(8, c) pressure for one pascal on each segment (`edges.SEGMENTS`), none on the others."""
    velocity: NDArray[np.float32]
    """(8, c, 2) mean velocity times viscosity, for the same."""
    path_m: float
    """Length of the way through the gap: volume over the area through which it is fed."""
    open_share: float
    """Share of the underside that no joint takes."""
    coverage: float
    """Share of the underside that joints take."""

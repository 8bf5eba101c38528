"""What reaches the exposed surfaces in one stage."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """The deposited volume as it grows with time: in block k cell ``cell[i]`` gains ``volume_mm[i]``."""

    until_s: Scalars
    """(b,) end of each block, from the beginning of the program, ascending."""
    start: Indices
    """(b + 1,) where each block's entries begin in the arrays below, and where the last ends."""
    cell: Indices
    """(k,) index into the cells of the facets."""
    volume_mm: NDArray[np.float32]
    """(k,)"""


@dataclass(frozen=True, slots=True, eq=False)
class Exposure:
    """What reaches each of c cells (``Facets``) in one stage. Zero where nothing does."""

    cone_s: Scalars
    """(c,) time in the outer cone, visible: the 1993 metric."""
    front_s: Scalars
    """(c,) time in which the flux is above a tenth of its peak."""
    volume_mm: Scalars
    """(c,) deposited volume per area."""
    peak_pa: Scalars
    """(c,) highest normal stress."""
    impulse_n_pa_s: Scalars
    """(c,) normal stress over time."""
    impulse_t_pa_s: Scalars
    """(c,) tangential stress over time."""
    hits: Indices
    """(c,) rays that landed: fewer than 30 say little."""
    sprayed_mm3: float
    """Volume that left the nozzle."""
    landed_mm3: float
    """Share of it that landed on a facet; the rest missed the board."""
    rays: int
    growth: Growth

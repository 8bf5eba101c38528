"""The board's surface, fine enough to say where it is wet."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles of all bodies, none longer than asked, and the cells into which small ones are gathered.

    Results are per cell: what one body shows to one of six directions within about a millimetre, large enough to be hit
    by enough rays. Board frame, mm.
    """

    triangles: Triangles
    """(m, 3, 3), wound so that the normal follows the right-hand rule."""
    normals: Directions
    """(m, 3) outward."""
    areas_mm2: Scalars
    """(m,)"""
    body: Indices
    """(m,) index into the board's bodies."""
    component: Indices
    """(m,) index into the board's components; -1 for the bare board and fixtures."""
    cell: Indices
    """(m,) cell of each facet."""
    cell_areas_mm2: Scalars
    """(c,) area that is not hidden; all of it where the whole cell is hidden."""
    cell_centres: Points
    """(c, 3) of the exposed area."""
    cell_normals: Directions
    """(c, 3) mean."""
    cell_component: Indices
    """(c,) index into the board's components; -1 for the bare board and fixtures."""
    exposed: NDArray[np.bool_]
    """(m,) whether a facet sees enough open sky over its own side to be sprayed at all; undersides do not."""
    cell_exposed: NDArray[np.bool_]
    """(c,) whether any facet of a cell is exposed."""

"""The sprayed faces of a part cut into cells: planning and analysis look at the same ones."""

from dataclasses import dataclass, replace

import numpy as np

from boards.board import Part
from geometry.arrays import Indices
from geometry.solids.cone_view import Cells, cut_cells

_CELL_MM = 4.0
_MOST_CELLS = 60_000
_COARSER = 1.4


@dataclass(frozen=True, slots=True, eq=False)
class FaceCells:
    """Cells of the served faces."""

    cells: Cells
    """``patch`` counts the part's own patches."""
    face: Indices
    """(c,) index into ``part.faces``."""


def served_cells(part: Part) -> FaceCells:
    """Cut the served faces of a part into cells of about 4 mm, coarser ones where that would be too many."""
    face_of = np.full(len(part.patches), -1, dtype=np.int64)
    for number, face in enumerate(part.faces):
        if face.serve:
            face_of[face.patches] = number
    served = np.flatnonzero(face_of >= 0)
    area = float(sum(face.area_mm2 for face in part.served))
    longest = max(_CELL_MM, float(np.sqrt(4.0 * area / _MOST_CELLS)))
    cells = cut_cells(part.patches[served], longest)
    while len(cells.points) > _MOST_CELLS and len(cells.points) > 2 * len(served):  # long patches give many
        longest *= _COARSER
        cells = cut_cells(part.patches[served], longest)
    cells = replace(cells, patch=served[cells.patch])
    return FaceCells(cells, face_of[cells.patch])

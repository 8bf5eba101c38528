"""The sprayed surface of a board, laid out once and drawn again and again in changing colours."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cleaning.surface.facets import Facets
from geometry.arrays import Directions, Indices, Points
from webui.glb.glb import Colours, flat_indexed_glb

_LIFT_MM = 0.03
"""Above the board that is drawn below, and above the part that is selected on it."""
_SHADE = np.array([0.16, 0.26, 0.0])
"""How much darker a surface is that looks along x, y or z: tops are as the legend says, walls tell apart from them."""
_FACETS = 6000
"""In one piece: where few cells change their colour, little is sent."""

_DRAWN = 500_000
"""A browser turns so many smoothly; where there are more, the small ones left out show the board beneath."""


@dataclass(frozen=True, slots=True, eq=False)
class HeatPiece:
    """Some cells and all exposed facets of theirs. Board frame, mm."""

    corners: Points
    """(n, 3) each once per cell."""
    cell: Indices
    """(n,) cell of each corner."""
    index: NDArray[np.uint32]
    """(3 k,) corners of each facet in turn."""
    cells: Indices
    """All that are in it, ascending."""


def heat_pieces(facets: Facets, most: int = _FACETS, drawn: int = _DRAWN) -> tuple[HeatPiece, ...]:
    """Lay out the exposed facets, a little lifted, in pieces of about so many; no cell is in two of them.

    Args:
        facets: What to draw; those that see no open sky are left out.
        most: Facets in one piece; more where a single cell has more.
        drawn: Facets altogether; of more the largest are drawn.
    """
    seen = np.flatnonzero(facets.exposed)
    if len(seen) > drawn:
        seen = np.sort(seen[np.argsort(-np.round(facets.areas_mm2[seen], 6), kind="stable")[:drawn]])
    seen = seen[np.argsort(facets.cell[seen], kind="stable")]
    if not len(seen):
        return ()
    cell = facets.cell[seen]
    first = np.searchsorted(cell, cell)  # where each facet's cell begins: a cell stays whole
    ends = np.flatnonzero(np.diff(first // most)) + 1
    return tuple(_piece(facets, each) for each in np.split(seen, ends))


def paint_piece(piece: HeatPiece, colours: Colours) -> bytes:
    """Draw a piece.

    Args:
        piece: What to draw.
        colours: (c, 3) of every cell of the board.
    """
    return flat_indexed_glb(piece.corners, colours[piece.cell], piece.index)


def shade(colours: Colours, normals: Directions) -> Colours:
    """(c, 3) colours of cells, darker where they face sideways, so that shapes are seen in plain colours.

    Args:
        colours: (c, 3)
        normals: (c, 3) of unit length or shorter.
    """
    return np.round(colours * (1.0 - normals**2 @ _SHADE)[:, None]).astype(np.uint8)


def has_changed(piece: HeatPiece, colours: Colours, before: Colours | None) -> bool:
    """Say whether a piece looks different in other colours; always where there were none."""
    return before is None or not np.array_equal(colours[piece.cells], before[piece.cells])


def _piece(facets: Facets, chosen: Indices) -> HeatPiece:
    lifted = facets.triangles[chosen] + _LIFT_MM * facets.normals[chosen][:, None, :]
    corners = np.ascontiguousarray(lifted.reshape(-1, 3) + 0.0, dtype=np.float32)  # + 0.0: there is no minus zero
    cell = np.repeat(facets.cell[chosen], 3)
    rows = np.column_stack([corners.view(np.uint32).astype(np.int64), cell])
    order = np.lexsort(rows.T)
    fresh = np.concatenate([[True], (rows[order[1:]] != rows[order[:-1]]).any(axis=1)])
    index = np.empty(len(rows), dtype=np.uint32)
    index[order] = np.cumsum(fresh) - 1
    kept = order[fresh]
    return HeatPiece(corners[kept].astype(np.float64), cell[kept], index, np.unique(cell))

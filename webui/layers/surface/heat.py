"""The sprayed surface of a board as pieces that are drawn in changing colours, and the volume on it over time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cleaning.exposure.exposure import Growth
from cleaning.surface.facets import Facets
from geometry.arrays import Directions, Indices, Points, Scalars
from webui.glb.glb import Colours, flat_indexed_glb, shared_corners

_LIFT_MM = 0.03
"""Above the board that is drawn below, and above the selected part."""
_SHADE = np.array([0.16, 0.26, 0.0])
"""How much darker a surface is that faces along x, y or z: tops match the legend, walls differ from them."""
_FACETS = 6000
"""In one piece: where few cells change their colour, little is sent."""
_DRAWN = 500_000
"""A browser turns so many smoothly; where there are more, the smallest are left out."""


@dataclass(frozen=True, slots=True, eq=False)
class HeatPiece:
    """Some cells with all their exposed facets. Board frame, mm."""

    corners: Points
    """(n, 3) each once per cell."""
    cell: Indices
    """(n,) cell of each corner."""
    index: NDArray[np.uint32]
    """(3 k,) corners of each facet in turn."""
    cells: Indices
    """Its cells, ascending."""


def heat_pieces(facets: Facets, most: int = _FACETS, drawn: int = _DRAWN) -> tuple[HeatPiece, ...]:
    """Exposed facets, slightly lifted, in pieces; no cell is in two of them.

    Args:
        facets: The surface; facets that are not exposed are left out.
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
    """A piece as binary glTF.

    Args:
        piece: The piece.
        colours: (c, 3) of every cell of the board.
    """
    return flat_indexed_glb(piece.corners, colours[piece.cell], piece.index)


def shade(colours: Colours, normals: Directions) -> Colours:
    """(c, 3) colours of cells, darker where they face sideways, so that shapes show in plain colours.

    Args:
        colours: (c, 3)
        normals: (c, 3) of unit length or shorter.
    """
    return np.round(colours * (1.0 - normals**2 @ _SHADE)[:, None]).astype(np.uint8)


def has_changed(piece: HeatPiece, colours: Colours, before: Colours | None) -> bool:
    """Whether a piece looks different in other colours; always where there were none."""
    return before is None or not np.array_equal(colours[piece.cells], before[piece.cells])


def _piece(facets: Facets, chosen: Indices) -> HeatPiece:
    lifted = facets.triangles[chosen] + _LIFT_MM * facets.normals[chosen][:, None, :]
    corners, cell = lifted.reshape(-1, 3), np.repeat(facets.cell[chosen], 3)
    kept, index = shared_corners(corners, cell)
    return HeatPiece(corners[kept], cell[kept], index, np.unique(cell))


class Accumulation:
    """Volume on the cells up to a time of the program; going forward costs only the new blocks.

    Not for several threads at once.
    """

    def __init__(self, growth: Growth, cells: int) -> None:
        """Begin with nothing.

        Args:
            growth: Volume by time block.
            cells: Number of cells.
        """
        self._growth, self._cells = growth, cells
        self._blocks = 0
        self._sum: Scalars = np.zeros(cells)

    def until(self, time_s: float) -> Scalars:
        """(c,) volume per area, mm, of all blocks that have ended at a time of the program."""
        blocks = int(np.searchsorted(self._growth.until_s, time_s, side="right"))
        if blocks < self._blocks:
            self._blocks, self._sum = 0, np.zeros(self._cells)
        if blocks > self._blocks:
            new = slice(int(self._growth.start[self._blocks]), int(self._growth.start[blocks]))
            self._sum = self._sum + np.bincount(
                self._growth.cell[new], self._growth.volume_mm[new], minlength=self._cells
            )
            self._blocks = blocks
        return self._sum

"""Heat maps as meshes: the sprayed surface in pieces, the volume on it over time, and the gaps under parts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from boards.undersides.underside import Underside
from cleaning.exposure.exposure import Growth
from cleaning.surface.facets import Facets
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Directions, Indices, Points, Points2, Scalars
from webui.glb.glb import Colours, as_seen, flat_indexed_glb, shared_corners
from webui.layers.surface.heat_scale import GapValues, Scale, harder_gap, scale_colours

_LIFT_MM = 0.03
"""Above the board that is drawn below, and above the selected part."""
_SHADE = np.array([0.16, 0.26, 0.0])
"""How much darker a surface is that faces along x, y or z: tops match the legend, walls differ from them."""
_FACETS = 6000
"""In one piece: where few cells change their colour, little is sent."""
_DRAWN = 500_000
"""A browser turns so many smoothly; where there are more, the smallest are left out."""
_OVER_PART_MM = 0.06
"""Lift of gap patches above the part, and above its own heat map."""
_PATCHES = 60_000
"""Where gaps have more cells, neighbouring ones are drawn as one."""
_JOINT = (141, 143, 146)
_MM = 1000.0


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
    pieces: list[HeatPiece] = []
    for chosen in np.split(seen, ends):
        lifted = facets.triangles[chosen] + _LIFT_MM * facets.normals[chosen][:, None, :]
        corners, owner = lifted.reshape(-1, 3), np.repeat(facets.cell[chosen], 3)
        kept, index = shared_corners(corners, owner)
        pieces.append(HeatPiece(corners[kept], owner[kept], index, np.unique(owner)))
    return tuple(pieces)


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


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Rectangles in the frame of one underside, mm."""

    middles: Points2
    """(n, 2)"""
    size: tuple[float, float]
    """Along x and y."""
    values: Scalars
    """(n,) not a number at joints."""


def gap_patches_glb(report: CleaningReport, stage: int, scale: Scale, most: int = _PATCHES) -> bytes:
    """Each gap that a stage acts on, seen through its part; of two bounds the harder.

    Args:
        report: The analysis.
        stage: Counted from 0.
        scale: Of the shear or the residue under parts.
        most: Patches altogether, about.
    """
    gaps = [
        (part.underside, values)
        for part in report.parts
        if part.underside is not None and (values := harder_gap(part, scale.measure.name, stage)) is not None
    ]
    total = sum(values.field.shape[0] * values.field.shape[1] for _, values in gaps)
    together = int(np.ceil(np.sqrt(total / most))) if total > most else 1
    drawn = [(underside, pool(values, together)) for underside, values in gaps]
    if not drawn:
        return b""
    corners = np.concatenate([place(report.board, underside, patches) for underside, patches in drawn])
    values = np.concatenate([patches.values for _, patches in drawn])
    colours = np.tile(np.array(_JOINT, dtype=np.uint8), (len(values), 1))
    known = np.isfinite(values)
    colours[known] = scale_colours(values[known], scale)
    first = 4 * np.arange(len(values), dtype=np.uint32)[:, None]
    index = (first + np.array([0, 1, 2, 0, 2, 3], dtype=np.uint32)).ravel()
    return flat_indexed_glb(corners.reshape(-1, 3), np.repeat(as_seen(colours), 4, axis=0), index)


def pool(gap: GapValues, together: int) -> Patches:
    """Mean of the open cells in blocks of so many along x and along y."""
    rows, columns = gap.field.shape
    down, across = -(-rows // together), -(-columns // together)
    row, column = np.divmod(gap.field.cells, columns)
    block = (row // together) * across + column // together
    count = np.bincount(block, minlength=down * across)
    sums = np.bincount(block, gap.values, minlength=down * across)
    values = np.where(count > 0, sums / np.maximum(count, 1), np.nan)
    size = (_MM * gap.field.length_m / across, _MM * gap.field.width_m / down)
    y, x = np.divmod(np.arange(down * across), across)
    middles = np.column_stack([(x + 0.5 - across / 2) * size[0], (y + 0.5 - down / 2) * size[1]])
    return Patches(middles, size, values)


def place(board: Board, underside: Underside, patches: Patches) -> NDArray[np.float64]:
    """(n, 4, 3) corners of patches on top of the part, mm in the board frame."""
    component = next(each for each in board.components if each.name == underside.component)
    outward = 1.0 if component.side == "top" else -1.0
    z = board.surface_z_mm(component.side) + outward * (component.height_mm + _OVER_PART_MM)
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(patches.size) / 2
    plan = (patches.middles[:, None, :] + half).reshape(-1, 2)
    cos, sin = np.cos(underside.turn_rad), np.sin(underside.turn_rad)
    turned: Points2 = plan @ np.array([[cos, sin], [-sin, cos]]) + (underside.x_mm, underside.y_mm)
    corners: Points = np.column_stack([turned, np.full(len(turned), z)])
    return corners.reshape(-1, 4, 3)

"""Shear or residue in the gaps, drawn on top of the parts above them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from boards.undersides.underside import Underside
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Points, Points2, Scalars
from webui.glb.glb import as_seen, flat_indexed_glb
from webui.layers.surface.heat_scale import GapValues, Scale, harder_gap, scale_colours

_LIFT_MM = 0.06
"""Above the part, and above its own heat map."""
_MOST = 60_000
"""Patches altogether: where there are more cells, neighbouring ones are drawn as one."""
_JOINT = (141, 143, 146)
_MM = 1000.0


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Rectangles in the frame of one underside, mm."""

    middles: Points2
    """(n, 2)"""
    size: tuple[float, float]
    """Along x and y."""
    values: Scalars
    """(n,) not a number at joints."""


def gap_patches_glb(report: CleaningReport, stage: int, scale: Scale, most: int = _MOST) -> bytes:
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
    z = board.surface_z_mm(component.side) + outward * (component.height_mm + _LIFT_MM)
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(patches.size) / 2
    plan = (patches.middles[:, None, :] + half).reshape(-1, 2)
    cos, sin = np.cos(underside.turn_rad), np.sin(underside.turn_rad)
    turned: Points2 = plan @ np.array([[cos, sin], [-sin, cos]]) + (underside.x_mm, underside.y_mm)
    corners: Points = np.column_stack([turned, np.full(len(turned), z)])
    return corners.reshape(-1, 4, 3)

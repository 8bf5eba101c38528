"""The edges of a selected part, drawn over a heat map."""

import numpy as np

from boards.board import Board
from geometry.arrays import Points
from webui.glb.glb import Colours
from webui.glb.ribbons import bars, board_size_mm, line_width_mm
from webui.theme.palette import ACCENT

_THICKEST = 0.03
"""Of the part's length."""


def outline_of(board: Board, name: str) -> tuple[Points, Colours]:
    """Draw the prism around a component as bars; nothing where there is no such component.

    Args:
        board: On which it stands.
        name: Its reference designator.

    Returns:
        (n, 3) corners of triangles, mm, and their colours.
    """
    component = next((each for each in board.components if each.name == name), None)
    if component is None:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.uint8)
    ring = np.asarray(component.outline.exterior.coords, dtype=np.float64)[:, :2]
    surface = board.surface_z_mm(component.side)
    top = surface + component.height_mm * (1.0 if component.side == "top" else -1.0)
    low, high = (np.column_stack([ring, np.full(len(ring), z)]) for z in (surface, top))
    edges = [np.stack([each[:-1], each[1:]], axis=1) for each in (low, high)]
    segments = np.concatenate([*edges, np.stack([low[:-1], high[:-1]], axis=1)])
    width = min(line_width_mm(board_size_mm(board)), _THICKEST * float(np.ptp(ring, axis=0).max()))
    return bars(segments, np.tile(np.array(ACCENT, dtype=np.uint8), (len(segments), 1)), width)

"""Outlines on a grid that lies on the board: what is decided there is decided the same wherever the board lies."""

import shapely
from shapely import Polygon

from boards.board import Board
from geometry.gridframe import GridFrame
from geometry.polygons import join_pieces


def own_frame(board: Board) -> GridFrame:
    """Frame of a board's outline: its first corner, and the direction of its longest edge."""
    x, y = board.outline.exterior.coords[0][:2]
    return GridFrame((float(x), float(y)), board.axis)


def into_frame(outline: Polygon, frame: GridFrame) -> Polygon:
    """Bring an outline from the board frame onto the grid of a frame; what the grid pinches off is joined again."""
    moved = shapely.transform(outline, frame.to_frame)
    return moved if moved.is_valid else join_pieces(moved.buffer(0.0))


def out_of_frame(outline: Polygon, frame: GridFrame) -> Polygon:
    """Bring an outline back into the board frame."""
    return shapely.transform(outline, frame.from_frame)

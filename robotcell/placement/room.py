"""Where a workpiece has room in a cell: on the table, between the fixtures."""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from boards.board import Workpiece
from geometry.arrays import Points
from robotcell.cell.cell import Cell
from robotcell.robot.robot import Body, Box, Capsule, Mesh, Poses, inverse

HasRoom: TypeAlias = Callable[[Poses], bool]
"""Whether a workpiece has room at a T_cell_board (4, 4)."""

_MM = 1e3
_SLACK = 1e-9


class TableBounds(NamedTuple):
    """A rectangle of the cell's x and y, m, in which the whole workpiece has to be."""

    x: tuple[float, float]
    y: tuple[float, float]


def room_on_table(bounds: TableBounds, points: Points) -> HasRoom:
    """Give the check whether points (n, 3) of the board's frame, m, are all above a rectangle of the cell."""
    try:
        hull = points[ConvexHull(points).vertices]
    except QhullError:
        hull = points  # they lie in a plane
    low, high = np.array([bounds.x[0], bounds.y[0]]) - _SLACK, np.array([bounds.x[1], bounds.y[1]]) + _SLACK

    def has_room(T_cell_board: Poses) -> bool:
        seen = hull @ T_cell_board[:2, :3].T + T_cell_board[:2, 3]
        return bool(np.all((seen >= low) & (seen <= high)))

    return has_room


def all_rooms(*rooms: HasRoom | None) -> HasRoom | None:
    """Join checks: there is room where all of them find some; ``None`` where there is no check."""
    known = [room for room in rooms if room is not None]
    return (lambda T_cell_board: all(room(T_cell_board) for room in known)) if known else None


def room_of(cell: Cell, board: Workpiece) -> HasRoom:
    """Give the check whether the box around a board keeps clear of fixtures and of the robot's base.

    What the box meets at the present place is left out: that is intended.
    """
    low, high = board_box(board)
    around = [corners_of(body) for body in cell.fixtures]
    base = [corners_of(body) for body in cell.robot.bodies[0]]
    around += [corners @ cell.T_cell_base[:3, :3].T + cell.T_cell_base[:3, 3] for corners in base]
    kept = [corners for corners in around if not meets_box(corners, low, high, cell.T_cell_board)]
    return lambda T_cell_board: not any(meets_box(corners, low, high, T_cell_board) for corners in kept)


def board_box(board: Workpiece) -> tuple[Points, Points]:
    """Give the lowest and the highest corner (3,) of the box around a board and its components, board frame, m."""
    low = np.min([body.patches.min(axis=(0, 1)) for body in board.bodies], axis=0) / _MM
    return low, np.max([body.patches.max(axis=(0, 1)) for body in board.bodies], axis=0) / _MM


def meets_box(corners: Points, low: Points, high: Points, T_cell_board: Poses) -> bool:
    """Whether the extent of points (n, 3) of the cell reaches into a box of the board's frame."""
    T_board_cell = inverse(T_cell_board)
    seen = corners @ T_board_cell[:3, :3].T + T_board_cell[:3, 3]
    return bool(np.all(seen.min(axis=0) < high) and np.all(seen.max(axis=0) > low))


def corners_of(body: Body) -> Points:
    """Give points (n, 3) that a body's convex hull is made of, in the frame of what carries it, m."""
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    match body.shape:
        case Box(size):
            points = signs * np.array(size) / 2.0
        case Capsule(radius, length):
            points = signs * np.array([radius, radius, length / 2.0 + radius])
        case Mesh(triangles):
            points = triangles.reshape(-1, 3)
    return points @ body.T_carrier_shape[:3, :3].T + body.T_carrier_shape[:3, 3]

"""Where a workpiece has room in a cell: on the table, between the fixtures."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geometry.arrays import Points
from robotcell.robot.robot import Poses

HasRoom: TypeAlias = Callable[[Poses], bool]
"""Whether a workpiece has room at a T_cell_board (4, 4)."""

_SLACK = 1e-9


class TableBounds(NamedTuple):
    """A rectangle of the cell's x and y, m, in which the whole workpiece has to be."""

    x: tuple[float, float]
    y: tuple[float, float]


def room_on_table(bounds: TableBounds, points: Points) -> HasRoom:
    """Give the check whether points (n, 3) of the board's frame, m, are all above a rectangle of the cell."""
    hull = _hull(points)
    low, high = np.array([bounds.x[0], bounds.y[0]]) - _SLACK, np.array([bounds.x[1], bounds.y[1]]) + _SLACK

    def has_room(T_cell_board: Poses) -> bool:
        seen = hull @ T_cell_board[:2, :3].T + T_cell_board[:2, 3]
        return bool(np.all((seen >= low) & (seen <= high)))

    return has_room


def all_rooms(*rooms: HasRoom | None) -> HasRoom | None:
    """Join checks: there is room where all of them find some; ``None`` where there is no check."""
    known = [room for room in rooms if room is not None]
    return (lambda T_cell_board: all(room(T_cell_board) for room in known)) if known else None


def _hull(points: Points) -> Points:
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points  # they lie in a plane

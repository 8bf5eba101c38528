"""Which bodies of robot and tool come near to what, and when."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from geometry.arrays import Points, Scalars
from robotcell.cell.cell import Cell
from robotcell.robot.poses import inverse
from webui.layers.robot.robot import JointMotion, joints_at, tool_at

if TYPE_CHECKING:
    from robotcell.collision.collision import Collider
    from robotcell.collision.contacts import Touch
    from robotcell.track import CellReport

_MM = 1000.0


@dataclass(frozen=True, slots=True, eq=False)
class Near:
    """Two bodies that are near each other at a moment of the program."""

    time_s: float
    body: str
    """What moves."""
    other: str
    distance_mm: float
    """0 where they overlap."""
    points: Points
    """(2, 3) nearest point of either, board frame, mm."""


def nearest_of(report: "CellReport", motion: JointMotion) -> Near | None:
    """Give where robot or tool come nearest to board or fixtures; nothing if all is far."""
    met = [
        (touch, row)
        for touch, row in zip(report.clearance.touches, report.clearance_at.tolist(), strict=True)
        if touch is not None
    ]
    if not met:
        return None
    touch, row = min(met, key=lambda each: round(each[0].distance, 6))
    return _near(report.cell, touch, float(motion.times[row]))


def clearances_mm(cell: Cell, board: Board, motion: JointMotion, rows: NDArray[np.intp]) -> tuple[Scalars, float]:
    """(k,) how near robot or tool are to board or fixtures at some moves, mm; and how far they are at most told apart.

    Args:
        cell: The cell.
        board: The board in it.
        motion: How the joints stand at each move.
        rows: (k,) the moves to look at.

    Raises:
        CellError: what ``washboard[robot]`` installs is missing.
    """
    from robotcell.collision.collision import FARTHEST, clearance

    collider = _collider(cell, board)
    tools = np.array([tool_at(motion, float(time_s)) for time_s in motion.times[rows]], dtype=np.int64)
    distances = np.zeros(len(rows))
    for tool in np.unique(tools).tolist():
        mine = tools == tool
        distances[mine] = clearance(collider, motion.joints[rows[mine]], tool).distances
    return distances * _MM, FARTHEST * _MM


def near_at(cell: Cell, board: Board, motion: JointMotion, time_s: float) -> Near | None:
    """Find what collides at a moment, or else what is nearest; nothing if all is far.

    Raises:
        CellError: what ``washboard[robot]`` installs is missing.
    """
    from robotcell.collision.collision import clearance, first_pairs

    collider, joints, tool = _collider(cell, board), joints_at(motion, np.array([time_s])), tool_at(motion, time_s)
    touch = first_pairs(collider, joints, tool)[0] or clearance(collider, joints, tool).touches[0]
    return None if touch is None else _near(cell, touch, time_s)


def moment_of(motion: JointMotion, places: Points, makers: tuple[str, ...], made_by: str, where: Points) -> float:
    """Say when the orifice is at a place, or nearest to it: among the moves of a maker if it has any, s.

    Args:
        motion: When each move is.
        places: (m, 3) where each move goes to, mm.
        makers: (m,) who asked for each.
        made_by: Who asked for the one that is looked for.
        where: (3,) mm.
    """
    own = np.array([maker == made_by for maker in makers], dtype=np.bool_)
    away = np.linalg.norm(places - where, axis=1)
    return float(motion.times[int(np.argmin(np.where(own | ~own.any(), away, np.inf)))])


@lru_cache(maxsize=2)
def _collider(cell: Cell, board: Board) -> "Collider":
    from robotcell.collision.collision import build_collider

    return build_collider(cell, board)


def _near(cell: Cell, touch: "Touch", time_s: float) -> Near:
    onto = inverse(cell.T_cell_board)
    points = (touch.points @ onto[:3, :3].T + onto[:3, 3]) * _MM
    return Near(time_s, touch.body, touch.other, touch.distance * _MM, points)

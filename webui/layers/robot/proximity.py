"""Clearance of robot and tool: the nearest pair of bodies, its time, and its mark in the scene."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Points, Scalars
from robotcell.cell.cell import Cell
from robotcell.robot.robot import inverse
from webui.glb.glb import flat_triangles_glb
from webui.glb.ribbons import bars
from webui.layers.robot.robot import JointMotion, joints_at, rows_by_tool, tool_at
from webui.theme.palette import COLLIDING

if TYPE_CHECKING:
    from robotcell.collision.body_pairs import Touch
    from robotcell.collision.collision import Collider
    from robotcell.track import CellReport

_MM = 1000.0
_LINE_MM, _END_MM = 0.8, 3.0
"""Widths of the line between two nearest points, and of the cubes at its ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Near:
    """Two bodies close to each other at a time of the program."""

    time_s: float
    body: str
    """The moving one."""
    other: str
    distance_mm: float
    """0 where they overlap."""
    points: Points
    """(2, 3) nearest point of either, board frame, mm."""


def nearest_of(report: "CellReport", motion: JointMotion) -> Near | None:
    """Smallest clearance of robot and tool to workpiece and fixtures; nothing if all is far."""
    met = [
        (touch, row)
        for touch, row in zip(report.clearance.touches, report.clearance_at.tolist(), strict=True)
        if touch is not None
    ]
    if not met:
        return None
    touch, row = min(met, key=lambda each: round(each[0].distance, 6))
    return _near(report.cell, touch, float(motion.times[row]))


def clearances_mm(
    cell: Cell, workpiece: Workpiece, motion: JointMotion, rows: NDArray[np.intp]
) -> tuple[Scalars, float]:
    """(k,) clearance of robot and tool to workpiece and fixtures at some moves, mm, and the largest that is measured.

    Args:
        cell: The cell.
        workpiece: The board or part in it.
        motion: Joints at each move.
        rows: (k,) indices of the moves.

    Raises:
        CellError: what ``washboard[robot]`` installs is missing.
    """
    from robotcell.collision.clearance import FARTHEST, clearance

    collider = _collider(cell, workpiece)
    distances = np.zeros(len(rows))
    for tool, mine in rows_by_tool(motion, rows):
        distances[mine] = clearance(collider, motion.joints[rows[mine]], tool).distances
    return distances * _MM, FARTHEST * _MM


def near_at(cell: Cell, workpiece: Workpiece, motion: JointMotion, time_s: float) -> Near | None:
    """Colliding pair at a time, or else the nearest; nothing if all is far.

    Raises:
        CellError: what ``washboard[robot]`` installs is missing.
    """
    from robotcell.collision.clearance import clearance
    from robotcell.collision.collision import first_pairs

    collider, joints, tool = _collider(cell, workpiece), joints_at(motion, np.array([time_s])), tool_at(motion, time_s)
    touch = first_pairs(collider, joints, tool)[0] or clearance(collider, joints, tool).touches[0]
    return None if touch is None else _near(cell, touch, time_s)


def near_glb(near: Near) -> bytes:
    """The line between the nearest points of two bodies, with a cube at either end, mm."""
    half = np.array([0.0, 0.0, _END_MM / 2])
    cubes = np.stack([near.points - half, near.points + half], axis=1)
    red = np.array([COLLIDING], dtype=np.uint8)
    line, ends = bars(near.points[None], red, _LINE_MM), bars(cubes, np.tile(red, (2, 1)), _END_MM)
    return flat_triangles_glb(np.concatenate([line[0], ends[0]]), np.concatenate([line[1], ends[1]]))


@lru_cache(maxsize=2)
def _collider(cell: Cell, workpiece: Workpiece) -> "Collider":
    from robotcell.collision.collision import build_collider

    return build_collider(cell, workpiece)


def _near(cell: Cell, touch: "Touch", time_s: float) -> Near:
    onto = inverse(cell.T_cell_board)
    points = (touch.points @ onto[:3, :3].T + onto[:3, 3]) * _MM
    return Near(time_s, touch.body, touch.other, touch.distance * _MM, points)

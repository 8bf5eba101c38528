"""The board in the cell: held by a corner or the centre of its outline, wherever the origin of its file is."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from robotcell.cell.load import LoadedCell
from robotcell.cell.measured_place import board_pose
from robotcell.cell.spec import HeldBy
from robotcell.robot.robot import Poses

_MM = 1e-3


def hold_board(loaded: LoadedCell, board: Workpiece | None) -> LoadedCell:
    """Give a cell that holds a board, in its first place and in those after ``CALL name``.

    Args:
        loaded: The cell; the board that it holds already, if any, is replaced.
        board: ``None`` where it is not known: the origin of its file is taken for the held point.
    """
    spec = loaded.spec
    T_board_held = held_frame(spec.board.held_by, board)
    cell = replace(loaded.cell, T_board_held=T_board_held).with_held_at(board_pose(spec.board))
    placements = {
        name: board_pose(hold) @ np.linalg.inv(held_frame(hold.held_by, board))
        for name, hold in spec.placements.items()
    }
    return replace(loaded, cell=cell, placements=placements)


def held_frame(held_by: HeldBy, board: Workpiece | None) -> Poses:
    """Give (4, 4) T_board_held, metres: the held point, with the board's axes."""
    T_board_held = np.eye(4)
    if board is not None:
        T_board_held[:3, 3] = _MM * held_point_mm(held_by, board)
    return T_board_held


def held_point_mm(held_by: HeldBy, board: Workpiece) -> NDArray[np.float64]:
    """Give a point (3,) of the rectangle around a workpiece, as ``plan_bounds_mm`` has it, in its frame, mm."""
    if held_by == "origin":
        return np.zeros(3)
    left, front, right, back, level = plan_bounds_mm(board)
    if held_by == "centre":
        return np.array([0.5 * (left + right), 0.5 * (front + back), level])
    x = left if held_by.endswith("left") else right
    return np.array([x, front if held_by.startswith("front") else back, level])


def plan_bounds_mm(workpiece: Workpiece) -> tuple[float, float, float, float, float]:
    """Give left, front, right and back of a workpiece without its fixtures, and the z at which a cell holds it, mm.

    A board is held at its top surface, a part stands on its lowest point.
    """
    (left, front, _), (right, back, _) = (corner.tolist() for corner in workpiece.box)
    return left, front, right, back, workpiece.held_z_mm


def describe_held(held_by: HeldBy) -> str:
    """Name a held point, as in ``"front left corner"``."""
    if held_by == "origin":
        return "origin of its file"
    return "centre" if held_by == "centre" else f"{held_by.replace('_', ' ')} corner"

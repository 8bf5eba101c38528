"""The frames of a cell in words and millimetres, for comparison with the real cell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from robotcell.cell.cell import Cell
from robotcell.cell.hold import describe_held, held_point_mm
from robotcell.cell.spec import HeldBy
from robotcell.robot.robot import flange_poses

_MM = 1e3
_CORNERS: tuple[HeldBy, ...] = ("front_left", "front_right", "back_right", "back_left")
_NAMED = (
    ("+x", (1, 0, 0)),
    ("-x", (-1, 0, 0)),
    ("+y", (0, 1, 0)),
    ("-y", (0, -1, 0)),
    ("up", (0, 0, 1)),
    ("down", (0, 0, -1)),
)


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame or corner in the cell, and its directions."""

    what: str
    place_mm: tuple[float, float, float]
    """In the cell."""
    looks: str
    """Its directions in words; empty where it has none."""


def frame_card(cell: Cell, board: Workpiece | None) -> tuple[Frame, ...]:
    """Give the robot's base, the tools' orifices at home, the board's frame and, if there is a board, its corners."""
    T_cell_flange = cell.T_cell_base @ flange_poses(cell.robot, cell.home[None])[0]
    frames = [
        _frame("robot base", cell.T_cell_base, "z"),
        _frame("flange at home", T_cell_flange, "z"),
    ]
    for tool in cell.tools:
        T_cell_tcp = T_cell_flange @ tool.T_flange_tcp
        label = f"tool {tool.number} {tool.name} at home"
        frames.append(_frame(label, T_cell_tcp, "jet"))
    frames.append(_frame("board's own frame", cell.T_cell_board, "top"))
    if board is not None:
        points: tuple[HeldBy, ...] = (*_CORNERS, "centre") if cell.held_by == "centre" else _CORNERS
        for point in points:
            in_cell = cell.T_cell_board[:3, :3] @ (held_point_mm(point, board) / _MM) + cell.T_cell_board[:3, 3]
            held = ", held" if point == cell.held_by else ""
            frames.append(Frame(f"board's {describe_held(point)}{held}", _place(in_cell), ""))
    return tuple(frames)


def board_corners(board: Workpiece) -> NDArray[np.float64]:
    """Give the corners (4, 3) of the rectangle around a board's outline on its top surface, board frame, mm."""
    return np.array([held_point_mm(corner, board) for corner in _CORNERS])


def describe_direction(direction: NDArray[np.float64]) -> str:
    """Describe where a unit vector (3,) of the cell frame points: the nearest axis, and how far off it is."""
    cosines = [float(np.dot(direction, axis)) for _, axis in _NAMED]
    nearest = int(np.argmax(np.round(cosines, 9)))
    off = np.degrees(np.arccos(min(1.0, cosines[nearest])))
    return _NAMED[nearest][0] + (f", {off:.1f} degrees off" if off >= 0.05 else "")


def _frame(what: str, T_cell_this: NDArray[np.float64], name: str) -> Frame:
    looks = f"{name} {describe_direction(T_cell_this[:3, 2])}, x along {describe_direction(T_cell_this[:3, 0])}"
    return Frame(what, _place(T_cell_this[:3, 3]), looks)


def _place(place: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (round(float(value) * _MM, 3) + 0.0 for value in place)
    return (x, y, z)

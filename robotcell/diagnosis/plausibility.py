"""Probable mistakes in a cell: other units, tools or boards turned over, poses out of reach; and its frames in words.

The frames, in millimetres, are for comparison with the real cell.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from robotcell.cell.cell import Cell, Tool, board_box, corners_of, longest_reach, meets_box
from robotcell.cell.hold import describe_held, held_point_mm
from robotcell.cell.spec import HeldBy, InputOutput
from robotcell.robot.robot import flange_poses, inverse
from specs import finding_rules as rules
from specs.finding import Finding
from specs.source import Source

_MM = 1e3
_SMALLEST_M = 3e-3
"""Tools and fixtures are never this small: the number was probably metres."""
_LARGEST_M = 20.0
_AHEAD_M = 0.02
"""What lies farther in front of an orifice, on the axis of its jet, is hit."""
_BESIDE_M, _BELOW_M = 0.002, 0.03
"""A fixture that is farther from the board, or farther under it, does not hold it; pins that do may not be drawn."""
_NO_CHANNELS = InputOutput()


def check_cell(cell: Cell, board: Workpiece | None, io: InputOutput = _NO_CHANNELS) -> tuple[Finding, ...]:
    """Find the classical mistakes. ``made_by`` is the place in the cell's file.

    Values that a recipe's quantities set are checked at the export of a program; values that the cell's own functions,
    solutions and grips set are checked here.

    Rules: ``analog-out-of-range``, ``tcp-units``, ``tcp-turned``, ``jet-hits-tool``, ``fixture-units``,
    ``board-upside-down``, ``board-out-of-reach`` and, with a board, ``fixture-in-board``.
    """
    findings = [finding for tool in cell.tools for finding in _check_tool(tool)]
    for body in cell.fixtures:
        size = float(np.ptp(corners_of(body), axis=0).max())
        if not _SMALLEST_M <= size <= _LARGEST_M:
            message = (
                f"{body.name} is {_MM * size:.4g} mm large; sizes are in mm, and mm_per_unit gives those of a mesh"
            )
            findings.append(Finding(rules.FIXTURE_UNITS, message, Source(entry=f"fixtures.{body.name}")))
    findings += _check_board(cell, board)
    findings += _check_channels(io)
    return tuple(findings)


def _check_tool(tool: Tool) -> Iterator[Finding]:
    at = Source(entry=f"tools.{tool.number}.tcp")
    length = float(np.linalg.norm(tool.T_flange_tcp[:3, 3]))
    if 0.0 < length < _SMALLEST_M:
        message = f"the orifice of {tool.name} is {_MM * length:.3g} mm from the flange; xyz_mm is in mm, not in metres"
        yield Finding(rules.TCP_UNITS, message, at)
    if length > _LARGEST_M:
        yield Finding(rules.TCP_UNITS, f"the orifice of {tool.name} is {length:g} m from the flange", at)
    T_tcp_flange = inverse(tool.T_flange_tcp)
    if length > 0.0 and T_tcp_flange[2, 3] > 0.5 * length:
        message = (
            f"the jet of {tool.name} points back at the flange; turn the TCP: add 180 degrees to the roll of rpy_deg"
        )
        yield Finding(rules.TCP_TURNED, message, at)
        return
    for body in tool.bodies:
        corners = corners_of(body) @ T_tcp_flange[:3, :3].T + T_tcp_flange[:3, 3]
        low, high = corners.min(axis=0), corners.max(axis=0)
        if high[2] > _AHEAD_M and np.all((low < 0.0) & (high > 0.0) | [False, False, True]):
            message = (
                f"the jet of {tool.name} hits its own {body.name}; check xyz_mm and rpy_deg, and where {body.name} is"
            )
            yield Finding(rules.JET_HITS_TOOL, message, at)


def _check_board(cell: Cell, board: Workpiece | None) -> Iterator[Finding]:
    up = float(cell.T_cell_board[2, 2])
    if up < -0.5:
        message = "the board's top faces down; unless intended, turn it over: add 180 degrees to the roll of rpy_deg"
        yield Finding(rules.BOARD_UPSIDE_DOWN, message, Source(entry="board"))
    corners = np.zeros((1, 3)) if board is None else board_corners(board) / _MM
    in_cell = corners @ cell.T_cell_board[:3, :3].T + cell.T_cell_board[:3, 3]
    first = (cell.T_cell_base @ cell.robot.joints[0].T_parent_joint)[:3, 3]
    nearest = float(np.linalg.norm(in_cell - first, axis=1).min())
    reach = longest_reach(cell)
    if nearest > reach:
        hint = "; xyz_mm is in mm" if nearest / 1000.0 < reach else ""
        message = (
            f"the board is {_MM * nearest:.0f} mm from the first joint; robot and tool reach {_MM * reach:.0f} mm{hint}"
        )
        yield Finding(rules.BOARD_OUT_OF_REACH, message, Source(entry="board"))
    if board is not None:
        low, high = board_box(board)
        for body in cell.fixtures:
            if meets_box(corners_of(body), low, high, cell.T_cell_board):
                message = f"{body.name} reaches into the box around {board.name}; lower the one or raise the other"
                yield Finding(rules.FIXTURE_IN_BOARD, message, Source(entry=f"fixtures.{body.name}"))
        around_m = np.array([_BESIDE_M, _BESIDE_M, _BELOW_M])
        near = (
            meets_box(corners_of(body), low - around_m, high + around_m, cell.T_cell_board) for body in cell.fixtures
        )
        if cell.fixtures and not any(near):
            message = (
                f"no fixture stands within {_MM * _BELOW_M:g} mm under {board.name}, nor within {_MM * _BESIDE_M:g} mm "
                "beside it; move the holder under it, or hold the board over the holder"
            )
            yield Finding(rules.BOARD_NOT_HELD, message, Source(entry="fixtures"))


def _check_channels(io: InputOutput) -> Iterator[Finding]:
    words = [("functions", io.functions), ("solutions", io.solutions)]
    words += [("grip", {"open": io.grip.open, "close": io.grip.close})]
    for kind, sets in words:
        for word, values in sets.items():
            for name, value in values.items():
                output = io.outputs[name]
                if output.kind == "analog" and abs(value) > output.full_scale:
                    goes = f"full scale is {output.full_scale:g} {output.unit}"
                    message = (
                        f"{word} sets {name} (analog output {output.number}) to {value:g} {output.unit}; its {goes}"
                    )
                    yield Finding(rules.ANALOG_OUT_OF_RANGE, message, Source(entry=f"io.{kind}.{word}.{name}"))


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
    frames = [_frame("robot base", cell.T_cell_base, "z"), _frame("flange at home", T_cell_flange, "z")]
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

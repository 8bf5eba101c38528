"""Pose of the board in the cell: stated, measured at three points, or touched. Metres."""

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from robotcell.cell.shapes import place_pose
from robotcell.cell.spec import Hold, PointPair
from robotcell.errors import CellError
from robotcell.robot.robot import Poses

_MM = 1e-3
_THINNEST = 0.02
"""Height of the triangle of three points to its longest side, below which their plane is not known well."""
_UNITS = ((1000.0, "metres"), (25.4, "inches"), (1 / 1000.0, "micrometres"), (1 / 25.4, "thousandths of an inch"))


def board_pose(hold: Hold) -> Poses:
    """Give (4, 4) the pose in the cell of the point that the board is held by, with the board's axes, metres.

    Raises:
        CellError: measured points lie on a line, or not as far apart as on the board; the reader adds file and line.
    """
    if hold.pose is not None:
        return place_pose(hold.pose)
    if hold.points is not None:
        return _fit(hold.points, hold.largest_residual_mm)
    if hold.touched is not None:
        points = np.array([hold.touched.origin_mm, hold.touched.on_x_mm, hold.touched.on_xy_mm])
        _check_plane(points, "in the cell")
        x = points[1] - points[0]
        z = np.cross(x, points[2] - points[0])
        x /= np.linalg.norm(x)
        z /= np.linalg.norm(z)
        turn: NDArray[np.float64] = np.column_stack([x, np.cross(z, x), z])
        return _assemble(turn, points[0] - turn @ np.array(hold.touched.board_mm or (0.0, 0.0, 0.0)))
    raise AssertionError("a hold gives the pose in one of three ways")


def _fit(pairs: list[PointPair], largest_mm: float) -> Poses:
    """Least-squares fit of a rigid pose: Arun, Huang and Blostein (1987), by singular values of the covariance.

    Three points lie in a plane, so a turn fits as well as its mirror image; the turn is taken.
    """
    on_board, in_cell = (np.array([getattr(pair, key) for pair in pairs]) for key in ("board_mm", "cell_mm"))
    _check_plane(on_board, "on the board")
    _check_plane(in_cell, "in the cell")
    from_middle, to_middle = on_board.mean(axis=0), in_cell.mean(axis=0)
    left, _, right = np.linalg.svd((on_board - from_middle).T @ (in_cell - to_middle))
    turn = (left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right).T
    place = to_middle - turn @ from_middle
    residual = float(np.linalg.norm(on_board @ turn.T + place - in_cell, axis=1).max())
    if residual <= largest_mm:
        return _assemble(turn, place)
    sides = list(combinations(range(3), 2))  # distances can be checked with a ruler
    there, here = ([math.dist(points[a], points[b]) for a, b in sides] for points in (on_board, in_cell))
    worst = max(range(3), key=lambda index: round(abs(there[index] - here[index]), 6))
    ratio = sum(there) / sum(here)
    units = [unit for factor, unit in _UNITS if abs(ratio / factor - 1) < 0.02]
    hint = f"the cell's points look like {units[0]}" if units else "measure again, or raise largest_residual_mm"
    raise CellError(
        f"points {sides[worst][0]} and {sides[worst][1]} are {there[worst]:.2f} mm apart on the board but "
        f"{here[worst]:.2f} mm in the cell; the best fit leaves {residual:.2f} mm; {hint}"
    )


def _check_plane(points: NDArray[np.float64], where: str) -> None:
    doubled = float(np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0])))
    longest = max(math.dist(a, b) for a, b in combinations(points.tolist(), 2))
    if doubled <= _THINNEST * longest**2:
        raise CellError(f"the three points lie on one line {where}; choose three corners")


def _assemble(turn: NDArray[np.float64], place_mm: NDArray[np.float64]) -> Poses:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turn, _MM * place_mm
    return result

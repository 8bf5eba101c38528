"""Pose of the board in the cell: stated, measured at its fiducials, or touched. Metres."""

import numpy as np
from numpy.typing import NDArray

from robotcell.cell.fiducials import check_plane, fit_fiducials
from robotcell.cell.shapes import place_pose
from robotcell.cell.spec import Hold
from robotcell.robot.robot import Poses

_MM = 1e-3


def board_pose(hold: Hold) -> Poses:
    """Give (4, 4) the pose in the cell of the point that the board is held by, with the board's axes, metres.

    Raises:
        CellError: measured points lie on a line, or do not fit those of the board; the reader adds file and line.
    """
    if hold.pose is not None:
        return place_pose(hold.pose)
    if hold.points is not None:
        fit = fit_fiducials(hold)
        return _assemble(fit.turn, fit.place_mm)
    if hold.touched is not None:
        points = np.array([hold.touched.origin_mm, hold.touched.on_x_mm, hold.touched.on_xy_mm])
        check_plane(points, "in the cell")
        x = points[1] - points[0]
        z = np.cross(x, points[2] - points[0])
        x /= np.linalg.norm(x)
        z /= np.linalg.norm(z)
        turn: NDArray[np.float64] = np.column_stack([x, np.cross(z, x), z])
        return _assemble(turn, points[0] - turn @ np.array(hold.touched.board_mm or (0.0, 0.0, 0.0)))
    raise AssertionError("a hold gives the pose in one of three ways")


def _assemble(turn: NDArray[np.float64], place_mm: NDArray[np.float64]) -> Poses:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turn, _MM * place_mm
    return result

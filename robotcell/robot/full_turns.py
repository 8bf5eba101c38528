"""Whole turns of revolute joints within their limits. Metres, radians."""

import numpy as np
from numpy.typing import NDArray

from robotcell.robot.robot import Joints, Robot

TURN = 2.0 * np.pi
ROUNDING = 1e-9
"""By how much a joint may be beyond a limit"""
_SLIGHTLY = 1e-6
"""Likewise, of the joints of a motion."""


def nearest_turns(robot: Robot, q: Joints, near: Joints) -> Joints:
    """Move rows (..., dof) by whole turns as near as the limits allow to others that broadcast; NaN rows where none is.

    Joints that turn without end come within half a turn.
    """
    least, most, inside = _whole_turns(robot, q)
    turns = np.where(robot.turning, np.clip(np.round((near - q) / TURN), least, most), 0.0)
    return np.where(inside[..., None], q + turns * TURN, np.nan)


def is_inside(robot: Robot, q: Joints) -> NDArray[np.bool_]:
    """Give which rows (..., dof) some number of whole turns brings within the limits; never rows of NaN."""
    return _whole_turns(robot, q)[2]


def is_beyond(robot: Robot, q: Joints) -> NDArray[np.bool_]:
    """Give which rows (..., dof) are beyond the limits of a joint as they are, without whole turns."""
    return np.any((q < robot.lowest - _SLIGHTLY) | (q > robot.highest + _SLIGHTLY), axis=-1)


def _whole_turns(robot: Robot, q: Joints) -> tuple[Joints, Joints, NDArray[np.bool_]]:
    """Least and most whole turns (..., dof) that the limits allow, and (...,) whether they allow any."""
    low, high = robot.lowest - ROUNDING, robot.highest + ROUNDING
    least, most = np.ceil((low - q) / TURN), np.floor((high - q) / TURN)
    return least, most, np.all(np.where(robot.turning, least <= most, (low <= q) & (q <= high)), axis=-1)

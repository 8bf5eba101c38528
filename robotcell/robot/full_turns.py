"""Whole turns within the limits of joints. Metres, radians."""

import itertools

import numpy as np
from numpy.typing import NDArray

from robotcell.robot.robot import Joints, Robot

TURN = 2.0 * np.pi
ROUNDING = 1e-9
"""By how much a joint may be beyond a limit"""


def windings(robot: Robot, q: Joints) -> Joints:
    """Give every row (m, dof) within the limits that differs from a row (dof,) by whole turns; in ascending order.

    Joints that turn without end keep their angle: they have no other.
    """
    choices = [_choices(robot, index, float(value)) for index, value in enumerate(q)]
    return np.array(list(itertools.product(*choices))).reshape(-1, robot.dof)


def unwound(robot: Robot, q: Joints, near: Joints) -> Joints:
    """Move rows (..., dof) by whole turns as near as the limits allow to others that broadcast; NaN rows where none is.

    Joints that turn without end come within half a turn.
    """
    lowest, highest, turning = _limits(robot)
    turns = np.round((near - q) / TURN)
    least, most = np.ceil((lowest - ROUNDING - q) / TURN), np.floor((highest + ROUNDING - q) / TURN)
    turns = np.where(turning, np.clip(turns, least, most), 0.0)
    moved = q + turns * TURN
    return np.where(is_inside(robot, q)[..., None], moved, np.nan)


def is_inside(robot: Robot, q: Joints) -> NDArray[np.bool_]:
    """Tell which rows (..., dof) some number of whole turns brings within the limits; never rows of NaN."""
    lowest, highest, turning = _limits(robot)
    least, most = np.ceil((lowest - ROUNDING - q) / TURN), np.floor((highest + ROUNDING - q) / TURN)
    straight = (lowest - ROUNDING <= q) & (q <= highest + ROUNDING)
    return np.all(np.where(turning, least <= most, straight), axis=-1)


def _limits(robot: Robot) -> tuple[Joints, Joints, NDArray[np.bool_]]:
    """Lowest, highest and whether it turns, (dof,) each."""
    lowest = np.array([joint.lowest for joint in robot.joints])
    highest = np.array([joint.highest for joint in robot.joints])
    return lowest, highest, np.array([joint.kind == "revolute" for joint in robot.joints])


def _choices(robot: Robot, index: int, value: float) -> list[float]:
    """What one joint may be, in ascending order."""
    joint = robot.joints[index]
    if joint.kind == "prismatic":
        inside = joint.lowest - ROUNDING <= value <= joint.highest + ROUNDING
        return [value] if inside else []
    if np.isinf(joint.lowest) or np.isinf(joint.highest):
        return [value]
    least = int(np.ceil((joint.lowest - ROUNDING - value) / TURN))
    most = int(np.floor((joint.highest + ROUNDING - value) / TURN))
    return [value + number * TURN for number in range(least, most + 1)]

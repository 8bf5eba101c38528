"""The joints of a gantry. Metres, radians.

It carries its nozzle by three straight axes and tilts it by two turning ones: five axes bring the orifice to a place
and the jet into a direction, and how the nozzle is turned about the jet then follows.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.compiled import compiled, inner
from robotcell.errors import CellError
from robotcell.kinematics.chain import Zero
from robotcell.kinematics.closed_forms import FREE, SLACK
from robotcell.robot.robot import Joints, Poses, Robot

_ALONG = 1e-3
"""Sine of the angle below which one direction is along another."""
_SAME = 1e-6
"""rad or m: branches that differ by less in every joint are one."""
_TURN = 2.0 * math.pi


class Gantry(NamedTuple):
    """Three straight axes, then two that turn. The base frame, metres."""

    zero: Zero
    straight: NDArray[np.float64]
    """(3, 3) the joints' way to a place."""


def recognise_gantry(zero: Zero) -> Gantry | None:
    """Give the gantry if three straight axes span space and two others turn about different directions."""
    along = zero.axes[:3].T
    tilting = float(np.linalg.norm(np.cross(zero.axes[3], zero.axes[4])))
    if abs(np.linalg.det(along)) < _ALONG or tilting < _ALONG:
        return None
    return Gantry(zero, np.linalg.inv(along).astype(np.float64))


def solve_gantry(gantry: Gantry, robot: Robot, poses: Poses, T_flange_tcp: Poses) -> tuple[Joints, NDArray[np.float64]]:
    """Give the joints (n, 2, 5), tilted one way and the other, and the azimuths (n, 2) that come of it.

    Where the jet lies along the first turning axis, that axis turns freely: the first branch takes the
    requested azimuth, the second the opposite one.

    Raises:
        CellError: the jet lies along the last axis, which then cannot tilt it.
    """
    requested = poses @ T_flange_tcp
    tip = gantry.zero.flange @ T_flange_tcp
    if np.linalg.norm(np.cross(gantry.zero.axes[4], tip[:3, 2])) < _ALONG:
        raise CellError(
            f"The jet lies along {robot.joints[4].name}, which cannot tilt it. Mount the tool across that axis."
        )
    rows, azimuth = np.full((len(poses), 2, 5), np.nan), np.full((len(poses), 2), np.nan)
    _solve((gantry.zero.axes, gantry.zero.points, gantry.straight), tip, requested, rows, azimuth)
    return rows, azimuth


@compiled
def _solve(
    machine: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    tip: Poses,
    requested: Poses,
    rows: Joints,
    azimuth: NDArray[np.float64],
) -> None:
    """Write joints and azimuths; both stay NaN where the jet cannot be tilted so far, or the branches are one."""
    swing, tilt = machine[0][3], machine[0][4]
    jet, turned, scratch = tip[:3, 2].copy(), np.empty(3), np.empty((5, 3))
    level = _dot(swing, tilt) * _dot(tilt, jet)
    _cross(tilt, jet, turned)
    across, even = _dot(swing, turned), _dot(swing, jet) - level
    most = math.hypot(even, across)
    aim = scratch[4]
    for row in range(len(requested)):
        for axis in range(3):
            aim[axis] = requested[row, axis, 2]
        _cross(aim, swing, turned)
        aside = _dot(turned, turned)
        share = _dot(aim, swing) - level
        left = (most - abs(share)) * (most + abs(share))
        if most > 1.0 - SLACK:  # the jet can lie along the first axis: there the difference would lose its digits
            left = aside
        if not left >= -SLACK:
            continue
        upright, lean = math.atan2(across, even), math.atan2(math.sqrt(max(left, 0.0)), share)
        free = math.sqrt(aside) < FREE
        for side in range(2):
            rows[row, side, 4] = upright + (lean if side == 0 else -lean)
            azimuth[row, side] = _swing(machine, (tip, requested[row]), (free, side), rows[row, side], scratch)
        if _is_same(rows[row, 0], rows[row, 1]):
            rows[row, 1] = np.nan
            azimuth[row, 1] = np.nan


@inner
def _swing(
    machine: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    poses: tuple[Poses, Poses],
    branch: tuple[bool, int],
    joints: Scalars,
    scratch: NDArray[np.float64],
) -> float:
    """Write the joints (5,) of a branch, of which the last is known; give its azimuth."""
    (axes, points, straight), (tip, pose), (free, side) = machine, poses, branch
    swing, tilt = axes[3], axes[4]
    turned, goal, now, pointed = scratch[0], scratch[1], scratch[2], scratch[3]
    # of what lies across the axis, however little it is: the jet, or the azimuth where the jet is along it
    across = 0 if free else 2
    for axis in range(3):
        pointed[axis] = tip[axis, across]
    _turn(tilt, joints[4], pointed, turned)
    _cross(swing, turned, now)
    for axis in range(3):
        pointed[axis] = pose[axis, across]
    _cross(swing, pointed, goal)
    _cross(now, goal, turned)
    joints[3] = math.atan2(_dot(turned, swing), _dot(now, goal)) + (side * math.pi if free else 0.0)
    for axis in range(3):
        goal[axis] = tip[axis, 3] - points[4, axis]
    _turn(tilt, joints[4], goal, turned)
    for axis in range(3):
        goal[axis] = turned[axis] + points[4, axis] - points[3, axis]
    _turn(swing, joints[3], goal, turned)
    for axis in range(3):
        goal[axis] = pose[axis, 3] - (turned[axis] + points[3, axis])
    for axis in range(3):
        joints[axis] = _dot(straight[axis], goal)
    for axis in range(3):
        pointed[axis] = tip[axis, 0]
    _turn(tilt, joints[4], pointed, goal)
    _turn(swing, joints[3], goal, turned)
    joints[3], joints[4] = _wrapped(joints[3]), _wrapped(joints[4])
    x = y = 0.0
    for axis in range(3):
        x += turned[axis] * pose[axis, 0]
        y += turned[axis] * pose[axis, 1]
    return math.atan2(y, x)


@inner
def _is_same(one: Scalars, other: Scalars) -> bool:
    """Whether branches are one."""
    for joint in range(5):
        apart = abs(one[joint] - other[joint])
        if (apart if joint < 3 else min(apart, _TURN - apart)) >= _SAME:
            return False
    return True


@inner
def _turn(axis: Scalars, angle: float, vector: Scalars, turned: Scalars) -> None:
    """Turn a vector about an axis; Rodrigues' formula."""
    c, s, along = math.cos(angle), math.sin(angle), _dot(vector, axis)
    _cross(axis, vector, turned)
    for each in range(3):
        held = along * axis[each]
        turned[each] = held + c * (vector[each] - held) + s * turned[each]


@inner
def _wrapped(angle: float) -> float:
    """Give the same angle in (-pi, pi]."""
    return angle - _TURN * math.ceil((angle - math.pi) / _TURN)


@inner
def _dot(one: Scalars, other: Scalars) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@inner
def _cross(one: Scalars, other: Scalars, out: Scalars) -> None:
    out[0] = one[1] * other[2] - one[2] * other[1]
    out[1] = one[2] * other[0] - one[0] * other[2]
    out[2] = one[0] * other[1] - one[1] * other[0]

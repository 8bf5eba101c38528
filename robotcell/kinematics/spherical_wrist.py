"""Every configuration of an arm whose last three axes meet in a point, compiled.

Pieper's way (1968): the first three joints bring the point where the last three axes meet to its place, the last three
turn about it. Where a joint turns freely (the point on axis 1, the wrist aligned) its branches take the preferred angle
and the one opposite, as the branches of every pose nearby lie opposite each other.
"""

import math

import numpy as np

from geometry.arrays import Indices
from geometry.compiled import compiled
from robotcell.kinematics.arm_types import SphericalArm
from robotcell.kinematics.chain import Chain, Matrix, Row, add_step
from robotcell.kinematics.polish import polish_rows
from robotcell.kinematics.subproblems import (
    FREE_ANGLE,
    NO_ANGLE,
    bend_to,
    first_turn,
    last_turn,
    tilt_of,
    turn_back,
    turn_to_plane,
)
from robotcell.robot.robot import Joints, Poses


@compiled
def solve_spherical(arm: SphericalArm, chain: Chain, poses: Poses, preferred: Joints, rows: Joints) -> Indices:
    """Write the rows (n, 8, 6) that bring the flange to poses (n, 4, 4) of the base frame; give how many each has."""
    count = np.zeros(len(poses), np.int64)
    moved = np.empty((3, 4))
    for index in range(len(poses)):
        wrist = arm.T_plane_base.copy()
        add_step(wrist, poses[index], moved)
        add_step(wrist, arm.T_flange_wrist, moved)
        spherical_branches(arm, wrist, preferred[index], rows[index])
        count[index] = polish_rows(chain, poses[index], rows[index])
    return count


@compiled
def spherical_branches(arm: SphericalArm, wrist: Poses, preferred: Row, rows: Joints) -> None:
    """Write the rows (8, 6) that bring the wrist frame to a pose (4, 4) of the plane frame, NaN where there is none.

    The order is shoulder (before, behind), elbow (left, right), wrist (axis 6 tilted forth, back), the last fastest.
    """
    rows[:] = np.nan
    arm_end, turned = np.empty((3, 3)), np.empty((3, 3))
    for side in range(2):
        found, shoulder, forward = turn_to_plane(wrist[0, 3], wrist[2, 3], arm.aside, side)
        if found == NO_ANGLE:
            continue
        if found == FREE_ANGLE:
            shoulder = preferred[0] + side * math.pi
        for elbow in range(2):
            found, first, second = bend_to(arm.bend, forward, wrist[1, 3], elbow, preferred[1])
            if found == NO_ANGLE:
                continue
            turn_back(wrist[:3, :3], shoulder, first + second, arm_end)
            _seen_from(arm.wrist, arm_end, turned)
            at = 4 * side + 2 * elbow
            rows[at : at + 2, 0] = shoulder
            rows[at : at + 2, 1] = first
            rows[at : at + 2, 2] = arm.signs[2] * second
            _turn_wrist(arm, turned, preferred[3], rows[at : at + 2])


@compiled
def _turn_wrist(arm: SphericalArm, turned: Matrix, preferred: float, rows: Joints) -> None:
    """Write joints 4 to 6 of both ways (2, 6) to turn the wrist."""
    for side in range(2):
        found, tilt = tilt_of(turned, side)
        first = preferred + side * math.pi if found == FREE_ANGLE else first_turn(turned, side)
        rows[side, 3] = first
        rows[side, 4] = tilt - arm.tilt
        rows[side, 5] = last_turn(turned, first)


@compiled
def _seen_from(frame: Matrix, matrix: Matrix, out: Matrix) -> None:
    """Write the transpose of a frame times a matrix; all (3, 3)."""
    for row in range(3):
        for column in range(3):
            out[row, column] = (
                frame[0, row] * matrix[0, column]
                + frame[1, row] * matrix[1, column]
                + frame[2, row] * matrix[2, column]
            )

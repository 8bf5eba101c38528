"""Polishing of closed-form solutions, compiled: checked by forward kinematics, Newton's steps, duplicates dropped."""

import math

import numpy as np
from numpy.typing import NDArray

from geometry.compiled import compiled
from robotcell.kinematics.chain import Chain, Matrix, Row, add_step, flange_at, step_over
from robotcell.robot.robot import Joints, Poses

EXACT = 1e-8
"""m + rad: what is nearer is left as it is. Closed forms are; the axes of a rounded URDF file are not quite square"""
ACCEPTED = 5e-7
"""m + rad: what is farther is no solution"""
SAME = 1e-6
"""rad or m: rows that differ by less in every joint are one; where branches meet, a root's rounding is most of it"""
DAMPING = 1e-8
"""Of the normal equations, whose unit is a metre and a radian: keeps steps at singular poses short"""
MOST_STEPS = 8


@compiled
def polish_rows(chain: Chain, pose: Poses, rows: Joints) -> int:
    """Improve rows (b, dof) in place and drop (NaN) what misses the pose (4, 4) or is there already.

    Turning joints come to lie in (-pi, pi].

    Returns:
        How many rows are left.
    """
    count = 0
    for index in range(len(rows)):
        q = rows[index]
        if math.isnan(q[0]):
            continue
        # "not <=" so that a pose of NaN is no pose
        if not _improve(chain, pose, q) <= ACCEPTED:
            q[:] = np.nan
            continue
        for joint in range(len(q)):
            if chain.turns[joint]:
                q[joint] -= 2.0 * math.pi * math.ceil((q[joint] - math.pi) / (2.0 * math.pi))
        if _is_known(chain.turns, rows[:index], q):
            q[:] = np.nan
        else:
            count += 1
    return count


@compiled
def _is_known(turns: NDArray[np.bool_], rows: Joints, q: Row) -> bool:
    for index in range(len(rows)):
        same = not math.isnan(rows[index, 0])
        for joint in range(len(q)):
            if not same:
                break
            apart = abs(q[joint] - rows[index, joint])
            if turns[joint]:
                apart = min(apart, 2.0 * math.pi - apart)
            same = apart < SAME
        if same:
            return True
    return False


@compiled
def _improve(chain: Chain, pose: Poses, q: Row) -> float:
    """Give by how much a row misses; improve it in place by Newton's steps if need be, never for the worse."""
    here = np.empty((4, 4))
    flange_at(chain.steps, chain.turns, q, here)
    miss = _miss(here, pose)
    if not (EXACT < miss < 0.1):
        return miss
    best = q.copy()
    trial = q.copy()
    for _ in range(MOST_STEPS):
        trial += _newton(chain, pose, here, trial)
        flange_at(chain.steps, chain.turns, trial, here)
        now = _miss(here, pose)
        if not now < miss:
            break
        miss = now
        best[:] = trial
        if miss < EXACT * 1e-3:
            break
    q[:] = best
    return miss


@compiled
def _miss(here: Poses, pose: Poses) -> float:
    """Metres and radians between two poses (4, 4), added up. The chord of a turn: twice the sine of half its angle."""
    along, turned = 0.0, 0.0
    for row in range(3):
        along += (here[row, 3] - pose[row, 3]) ** 2
        for column in range(3):
            turned += (here[row, column] - pose[row, column]) ** 2
    return math.sqrt(along) + math.sqrt(turned / 2.0)


@compiled
def _newton(chain: Chain, pose: Poses, here: Poses, q: Row) -> Row:
    """Give the damped Newton step (dof,) that brings the flange from where it is towards a pose."""
    twist = np.zeros(6)
    for axis in range(3):
        twist[axis] = pose[axis, 3] - here[axis, 3]
    for column in range(3):
        for axis in range(3):
            one, two = (axis + 1) % 3, (axis + 2) % 3
            twist[3 + axis] += (here[one, column] * pose[two, column] - here[two, column] * pose[one, column]) / 2.0
    slopes = _slopes(chain, here, q)
    dof = len(q)
    square, right = np.zeros((dof, dof)), np.zeros(dof)
    for one in range(dof):
        for axis in range(6):
            right[one] += slopes[axis, one] * twist[axis]
            for two in range(dof):
                square[one, two] += slopes[axis, one] * slopes[axis, two]
        square[one, one] += DAMPING
    step = np.empty(dof)
    step[:] = np.linalg.solve(square, right)
    return step


@compiled
def _slopes(chain: Chain, here: Poses, q: Row) -> Matrix:
    """(6, dof) the geometric Jacobian of the flange."""
    slopes = np.zeros((6, len(q)))
    frame, moved = chain.steps[0].copy(), np.empty((3, 4))
    for joint in range(len(q)):
        for axis in range(3):
            if not chain.turns[joint]:
                slopes[axis, joint] = frame[axis, 2]
                continue
            one, two = (axis + 1) % 3, (axis + 2) % 3
            slopes[3 + axis, joint] = frame[axis, 2]
            slopes[axis, joint] = frame[one, 2] * (here[two, 3] - frame[two, 3]) - frame[two, 2] * (
                here[one, 3] - frame[one, 3]
            )
        step_over(frame, chain.turns[joint], q[joint])
        add_step(frame, chain.steps[joint + 1], moved)
    return slopes

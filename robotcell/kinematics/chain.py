"""A robot as a chain for compiled loops: flange pose, Jacobian, manipulability, polishing of IK solutions."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.compiled import compiled
from robotcell.robot.robot import Joints, Poses, Robot, flange_poses, link_poses

Row: TypeAlias = NDArray[np.float64]  # (dof,)
Matrix: TypeAlias = NDArray[np.float64]  # (3, 3) unless stated


EXACT = 1e-8
"""m + rad: what is nearer is left as it is. Closed forms are; the axes of a rounded URDF file are not quite square"""
ACCEPTED = 5e-7
"""m + rad: what is farther is no solution"""
SAME = 1e-6
"""rad or m: rows that differ by less in every joint are one; where branches meet, a root's rounding is most of it"""
DAMPING = 1e-8
"""Of the normal equations, whose unit is a metre and a radian: keeps steps at singular poses short"""
MOST_STEPS = 8


class Chain(NamedTuple):
    """A robot for compiled loops. Metres, base frame."""

    steps: Poses
    """(dof + 1, 4, 4) from one joint's frame to the next, the first from the base, the last to the flange."""
    turns: NDArray[np.bool_]
    """(dof,) whether a joint turns about the z of its frame; else it moves along it."""


class Zero(NamedTuple):
    """Where everything is while all joints are at zero. Metres, base frame."""

    axes: NDArray[np.float64]
    """(dof, 3) unit vectors."""
    points: NDArray[np.float64]
    """(dof, 3) a point on each axis."""
    flange: Poses
    """(4, 4)"""


def chain_of(robot: Robot) -> Chain:
    """Give a robot's joints as steps from axis to axis."""
    steps = np.empty((robot.dof + 1, 4, 4))
    onto = np.eye(4)
    for index, joint in enumerate(robot.joints):
        away = np.eye(4)
        away[:3, :3] = frame_along(joint.axis)
        steps[index] = onto @ joint.T_parent_joint @ away
        onto = away.T
    steps[-1] = onto @ robot.T_link_flange
    return Chain(steps, robot.turning)


def zero_of(robot: Robot) -> Zero:
    """Give a robot's axes and its flange at zero."""
    rest = np.zeros((1, robot.dof))
    links = link_poses(robot, rest)[0, 1:]
    axes = np.array([link[:3, :3] @ joint.axis for link, joint in zip(links, robot.joints, strict=True)])
    return Zero(axes, links[:, :3, 3], flange_poses(robot, rest)[0])


def frame_along(axis: Row) -> Matrix:
    """Give a rotation (3, 3) that takes z to a unit vector; its x is arbitrary."""
    helper = np.zeros(3)
    helper[np.argmin(np.abs(axis))] = 1.0
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return np.stack((x, np.cross(axis, x), axis), axis=1)


@compiled
def flange_at(steps: Poses, turns: NDArray[np.bool_], q: Row, pose: Poses) -> None:
    """Write the flange's pose (4, 4) at one row of joints."""
    pose[:] = steps[0]
    moved = np.empty((3, 4))
    for joint in range(len(turns)):
        step_over(pose, turns[joint], q[joint])
        add_step(pose, steps[joint + 1], moved)


@compiled
def step_over(pose: Poses, turns: bool, value: float) -> None:
    """Turn about or move along the pose's own z."""
    if not turns:
        for row in range(3):
            pose[row, 3] += pose[row, 2] * value
        return
    c, s = math.cos(value), math.sin(value)
    for row in range(3):
        x, y = pose[row, 0], pose[row, 1]
        pose[row, 0], pose[row, 1] = c * x + s * y, c * y - s * x


@compiled
def add_step(pose: Poses, step: Poses, moved: NDArray[np.float64]) -> None:
    """Multiply a pose by a fixed step, in place."""
    for row in range(3):
        for column in range(4):
            moved[row, column] = (
                pose[row, 0] * step[0, column] + pose[row, 1] * step[1, column] + pose[row, 2] * step[2, column]
            )
        moved[row, 3] += pose[row, 3]
    for row in range(3):
        for column in range(4):
            pose[row, column] = moved[row, column]


@compiled
def write_jacobian(
    steps: Poses, turns: NDArray[np.bool_], q: Row, pose: Poses, frames: NDArray[np.float64], out: Matrix
) -> None:
    """Write the flange's pose (4, 4) and its geometric Jacobian (6, dof) at one row of joints.

    The ``frames`` (dof + 1, 3, 4) are scratch.
    """
    dof = len(turns)
    pose[:] = steps[0]
    for joint in range(dof):
        frames[joint] = pose[:3]
        step_over(pose, turns[joint], q[joint])
        add_step(pose, steps[joint + 1], frames[dof])
    for joint in range(dof):
        x, y, z = frames[joint, 0, 2], frames[joint, 1, 2], frames[joint, 2, 2]
        if turns[joint]:
            a, b, c = (
                pose[0, 3] - frames[joint, 0, 3],
                pose[1, 3] - frames[joint, 1, 3],
                pose[2, 3] - frames[joint, 2, 3],
            )
            out[0, joint], out[1, joint], out[2, joint] = y * c - z * b, z * a - x * c, x * b - y * a
            out[3, joint], out[4, joint], out[5, joint] = x, y, z
        else:
            out[0, joint], out[1, joint], out[2, joint] = x, y, z
            out[3:, joint] = 0.0


@compiled
def manipulability(steps: Poses, turns: NDArray[np.bool_], q: Joints) -> Scalars:
    """Give |det J| (m,) of six-axis configurations (m, 6); it does not depend on where the tool's tip is.

    Yoshikawa, "Manipulability of robotic mechanisms" (1985), for a square Jacobian.
    """
    dof = len(turns)
    result = np.empty(len(q))
    pose, frames, jacobian = np.empty((4, 4)), np.empty((dof + 1, 3, 4)), np.empty((6, dof))
    for row in range(len(q)):
        write_jacobian(steps, turns, q[row], pose, frames, jacobian)
        result[row] = abs(np.linalg.det(jacobian))
    return result


@compiled
def polish_rows(chain: Chain, poses: Poses, rows: Joints) -> None:
    """Improve rows (n, b, dof) in place and drop (NaN) what misses its pose (n, 4, 4) or is there already.

    Turning joints come to lie in (-pi, pi].
    """
    for number in range(len(poses)):
        for index in range(rows.shape[1]):
            q = rows[number, index]
            if math.isnan(q[0]):
                continue
            # "not <=" so that a pose of NaN is no pose
            if not _improve(chain, poses[number], q) <= ACCEPTED:
                q[:] = np.nan
                continue
            for joint in range(len(q)):
                if chain.turns[joint]:
                    q[joint] -= 2.0 * math.pi * math.ceil((q[joint] - math.pi) / (2.0 * math.pi))
            if _is_known(chain.turns, rows[number, :index], q):
                q[:] = np.nan


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
    dof = len(q)
    frames, slopes = np.empty((dof + 1, 3, 4)), np.empty((6, dof))
    write_jacobian(chain.steps, chain.turns, q, np.empty((4, 4)), frames, slopes)
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

"""A robot as bare numbers for compiled loops: frames whose z is the joint's axis, and the flange they lead to."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.compiled import compiled
from robotcell.robot.robot import Joints, Poses, Robot, flange_poses, link_poses

Row: TypeAlias = NDArray[np.float64]  # (dof,)
Matrix: TypeAlias = NDArray[np.float64]  # (3, 3) unless stated


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
def manipulability(steps: Poses, turns: NDArray[np.bool_], q: Joints) -> Scalars:
    """Give |det J| (m,) of six-axis configurations (m, 6); it does not depend on where the tool's tip is.

    Yoshikawa, "Manipulability of robotic mechanisms" (1985), for a square Jacobian.
    """
    dof = len(turns)
    result = np.empty(len(q))
    pose, moved = np.eye(4), np.empty((3, 4))
    axes, places, jacobian = np.empty((dof, 3)), np.empty((dof, 3)), np.empty((6, dof))
    for row in range(len(q)):
        pose[:] = steps[0]
        for joint in range(dof):
            axes[joint], places[joint] = pose[:3, 2], pose[:3, 3]
            step_over(pose, turns[joint], q[row, joint])
            add_step(pose, steps[joint + 1], moved)
        for joint in range(dof):
            x, y, z = axes[joint]
            if turns[joint]:
                a, b, c = pose[:3, 3] - places[joint]
                jacobian[0, joint], jacobian[1, joint], jacobian[2, joint] = y * c - z * b, z * a - x * c, x * b - y * a
                jacobian[3:, joint] = axes[joint]
            else:
                jacobian[:3, joint] = axes[joint]
                jacobian[3:, joint] = 0.0
        result[row] = abs(np.linalg.det(jacobian))
    return result

"""A robot as a chain of joints: where its links are, and how they move. Metres, radians.

Frames: ``base`` is the robot's own base frame; link 0 stands still in it, link i moves with joint i (counted from 1);
the flange is fixed to the last link. Angles and lengths of the joints are one row ``q`` of ``(dof,)``.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Poses: TypeAlias = NDArray[np.float64]  # (..., 4, 4) homogeneous, metres
Joints: TypeAlias = NDArray[np.float64]  # (..., dof) radians or metres
Jacobians: TypeAlias = NDArray[np.float64]  # (..., 6, dof) linear (m), then angular, in the base frame
JointKind: TypeAlias = Literal["revolute", "prismatic"]


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One moving joint and what it may do."""

    name: str
    kind: JointKind
    T_parent_joint: Poses
    """(4, 4) where the joint stands on the link before it, at zero."""
    axis: NDArray[np.float64]
    """(3,) unit vector in the joint's frame: turned about, or moved along."""
    lowest: float
    """rad or m; minus infinity where it turns without end."""
    highest: float
    speed: float
    """Greatest, rad/s or m/s."""
    acceleration: float
    """Greatest, rad/s² or m/s²."""


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """Centred on its frame."""

    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Capsule:
    """Along z, centred; the caps come on top of the length."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles, metres."""

    triangles: NDArray[np.float64]
    """(n, 3, 3)"""


Shape: TypeAlias = Box | Capsule | Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A rigid body that can collide, and where it is on what carries it."""

    name: str
    shape: Shape
    T_carrier_shape: Poses
    """(4, 4)"""


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """A serial chain of moving joints."""

    name: str
    joints: tuple[Joint, ...]
    T_link_flange: Poses
    """(4, 4) the flange on the last link."""
    bodies: tuple[tuple[Body, ...], ...]
    """Of each link, base first: (dof + 1) tuples."""

    @property
    def dof(self) -> int:
        """How many joints move."""
        return len(self.joints)


def link_poses(robot: Robot, q: Joints) -> Poses:
    """Give where the links are: (n, dof + 1, 4, 4) in the base frame, for (n, dof) joint rows."""
    poses = np.empty((len(q), robot.dof + 1, 4, 4))
    poses[:, 0] = np.eye(4)
    for index, joint in enumerate(robot.joints):
        np.matmul(poses[:, index] @ joint.T_parent_joint, _moved(joint, q[:, index]), out=poses[:, index + 1])
    return poses


def flange_poses(robot: Robot, q: Joints) -> Poses:
    """Give where the flange is: (n, 4, 4) in the base frame, for (n, dof) joint rows."""
    return link_poses(robot, q)[:, -1] @ robot.T_link_flange


def jacobians(robot: Robot, q: Joints, T_flange_tcp: Poses | None = None) -> Jacobians:
    """Give the geometric Jacobians of a point on the flange: (n, 6, dof), base frame, linear rows first.

    Args:
        robot: The chain.
        q: (n, dof) joint rows.
        T_flange_tcp: (4, 4) the point; the flange's own origin if left out.
    """
    links = link_poses(robot, q)
    tip = links[:, -1] @ robot.T_link_flange
    at = (tip if T_flange_tcp is None else tip @ T_flange_tcp)[:, :3, 3]
    columns = np.zeros((len(q), 6, robot.dof))
    for index, joint in enumerate(robot.joints):
        frame = links[:, index] @ joint.T_parent_joint
        axis = frame[:, :3, :3] @ joint.axis
        if joint.kind == "prismatic":
            columns[:, :3, index] = axis
        else:
            columns[:, :3, index] = np.cross(axis, at - frame[:, :3, 3])
            columns[:, 3:, index] = axis
    return columns


def _moved(joint: Joint, values: NDArray[np.float64]) -> Poses:
    """(n, 4, 4) what a joint adds at each of its positions; Rodrigues' formula for a turn."""
    poses = np.zeros((len(values), 4, 4))
    poses[:] = np.eye(4)
    if joint.kind == "prismatic":
        poses[:, :3, 3] = values[:, None] * joint.axis
        return poses
    x, y, z = joint.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, cosine = np.sin(values)[:, None, None], np.cos(values)[:, None, None]
    poses[:, :3, :3] = np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
    return poses

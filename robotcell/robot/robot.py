"""A robot as a chain of joints: where its links are, and how they move. Metres, radians.

Frames: ``base`` is the robot's own base frame; link 0 stands still in it, link i moves with joint i (counted from 1);
the flange is fixed to the last link. Angles and lengths of the joints are one row ``q`` of ``(dof,)``.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from programs.motion.installation import JointConvention, Maker

Poses: TypeAlias = NDArray[np.float64]  # (..., 4, 4) homogeneous, metres
Joints: TypeAlias = NDArray[np.float64]  # (..., dof) radians or metres
Jacobians: TypeAlias = NDArray[np.float64]  # (..., 6, dof) linear (m), then angular, in the base frame
JointKind: TypeAlias = Literal["revolute", "prismatic"]

CHARACTERISTIC_LENGTH = 0.25
"""m that count as much as a radian in the inverse condition: about the size of a board.

One length for all robots, so that they can be compared at the same work."""
_ROWS_AT_ONCE = 16_384
"""Rows of joints or poses that are worked on together: a row takes a kilobyte or two while that lasts."""


class JointUnit(NamedTuple):
    """The unit of a joint's values in files and messages."""

    si: float
    """rad or m."""
    per_si: float
    """Units in a radian or a metre."""
    key: Literal["deg", "mm"]
    word: Literal["degrees", "mm"]


_UNITS: dict[JointKind, JointUnit] = {
    "revolute": JointUnit(math.pi / 180, 180 / math.pi, "deg", "degrees"),
    "prismatic": JointUnit(1e-3, 1e3, "mm", "mm"),
}


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One moving joint and its limits."""

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

    @property
    def unit(self) -> JointUnit:
        """Degrees where it turns, millimetres where it slides."""
        return _UNITS[self.kind]


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
    maker: Maker | None = None
    """Whose controller it has; ``None`` if that is not stated."""
    convention: JointConvention | None = None
    """How that controller counts the joints; ``None`` if it counts them as they are here."""

    @property
    def dof(self) -> int:
        """How many joints move."""
        return len(self.joints)

    @property
    def lowest(self) -> NDArray[np.float64]:
        """(dof,) rad or m."""
        return np.array([joint.lowest for joint in self.joints])

    @property
    def highest(self) -> NDArray[np.float64]:
        """(dof,) rad or m."""
        return np.array([joint.highest for joint in self.joints])

    @property
    def middle(self) -> NDArray[np.float64]:
        """(dof,) middle of the limits, rad or m; 0 where a joint turns without end."""
        limits = [(joint.lowest, joint.highest) for joint in self.joints]
        return np.array([0.5 * (low + high) if np.isfinite(high - low) else 0.0 for low, high in limits])

    @property
    def speed(self) -> NDArray[np.float64]:
        """(dof,) greatest speeds, rad/s or m/s."""
        return np.array([joint.speed for joint in self.joints])

    @property
    def acceleration(self) -> NDArray[np.float64]:
        """(dof,) greatest accelerations, rad/s² or m/s²."""
        return np.array([joint.acceleration for joint in self.joints])

    @property
    def turning(self) -> NDArray[np.bool_]:
        """(dof,) whether a joint is revolute."""
        return np.array([joint.kind == "revolute" for joint in self.joints])


def row_pieces(count: int, most: int = _ROWS_AT_ONCE) -> Iterator[slice]:
    """Give slices that cut that many rows into pieces: bounds the memory of what is done row by row."""
    for begin in range(0, count, most):
        yield slice(begin, min(begin + most, count))


def rows_by(number: Indices) -> Iterator[tuple[int, Indices]]:
    """Give each number of (n,), such as that of a tool, and the rows that have it."""
    for each in np.unique(number).tolist():
        yield each, np.flatnonzero(number == each)


def link_poses(robot: Robot, q: Joints) -> Poses:
    """Give where the links are: (n, dof + 1, 4, 4) in the base frame, for (n, dof) joint rows."""
    from robotcell.robot.link_frames import write_links  # numba takes a moment to load

    poses = np.empty((len(q), robot.dof + 1, 4, 4))
    write_links(_motions(robot), robot.turning, np.asarray(q, dtype=np.float64), poses)
    return poses


@lru_cache(maxsize=16)
def _motions(robot: Robot) -> NDArray[np.float64]:
    """Give each joint's motion as a sum of constant matrices (dof, 3, 4, 4)."""
    terms = np.zeros((robot.dof, 3, 4, 4))
    for index, joint in enumerate(robot.joints):
        part = np.zeros((4, 4))
        if joint.kind == "prismatic":
            part[:3, 3] = joint.axis
        else:  # Rodrigues' formula
            x, y, z = joint.axis
            part[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        terms[index, 0] = joint.T_parent_joint
        terms[index, 1] = joint.T_parent_joint @ part
        terms[index, 2] = terms[index, 1] @ part
    return terms


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


def singularity(
    robot: Robot, q: Joints, T_flange_tcp: Poses | None = None, *, length: float = CHARACTERISTIC_LENGTH
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Measure how well a point of the flange can be moved in every direction.

    Args:
        robot: The robot.
        q: (n, dof) joint rows.
        T_flange_tcp: (4, 4) the point; the flange's own origin if left out.
        length: m, the characteristic length of the inverse condition.

    Returns:
        w (n,), Yoshikawa's manipulability sqrt(det(J J^T)) in m and rad, for five axes sqrt(det(J^T J)); with six axes
        it does not depend on the point. And the inverse condition (n,), between 0 where singular and 1 where all
        directions are alike, of the Jacobian with lengths divided by the characteristic length.
    """
    w, condition = np.empty(len(q)), np.empty(len(q))
    for rows in row_pieces(len(q)):
        slopes = jacobians(robot, q[rows], T_flange_tcp)
        w[rows] = _volumes(slopes)
        slopes[:, :3] /= length
        slopes[:, :, ~robot.turning] *= length
        sizes = np.linalg.svd(slopes, compute_uv=False)
        condition[rows] = sizes[:, -1] / sizes[:, 0]
    return w, condition


def flange_manipulability(robot: Robot, q: Joints) -> NDArray[np.float64]:
    """Give the manipulability (n,) of the flange's own origin as ``singularity`` has it, which takes twice as long."""
    pieces = [_volumes(jacobians(robot, q[rows])) for rows in row_pieces(len(q))]
    return np.concatenate([np.empty(0), *pieces])


def _volumes(slopes: Jacobians) -> NDArray[np.float64]:
    """(n,) how much joints that move by a unit can move the point."""
    if slopes.shape[2] == 6:
        return np.abs(np.linalg.det(slopes))
    return np.sqrt(np.maximum(0.0, np.linalg.det(np.swapaxes(slopes, 1, 2) @ slopes)))


def limit_share(robot: Robot, q: Joints) -> NDArray[np.float64]:
    """Give how far (n,) the nearest joint is from its nearer limit: 0 at the limit, 1 in the middle of its range."""
    low, high = robot.lowest, robot.highest
    bounded = np.isfinite(low) & np.isfinite(high)
    if not bounded.any():
        return np.ones(len(q))
    near = np.minimum(q - low, high - q)[:, bounded] / (0.5 * (high - low)[bounded])
    return np.clip(near.min(axis=1), 0.0, 1.0)


def pose(xyz: Sequence[float], rpy: Sequence[float]) -> Poses:
    """Give the (4, 4) pose at ``xyz`` turned by ``rpy`` radians.

    Roll, pitch, yaw as in URDF: first about x, then about y, then about z, all of the frame that stands still;
    R = Rz(yaw) Ry(pitch) Rx(roll).
    """
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    result = np.eye(4)
    result[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    result[:3, 3] = xyz
    return result


def inverse(T: Poses) -> Poses:
    """Give the inverse of a rigid (4, 4) pose."""
    result = np.eye(4)
    result[:3, :3] = T[:3, :3].T
    result[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return result


def roll_pitch_yaw(T: Poses) -> tuple[float, float, float]:
    """Give the turns of a (4, 4) pose as ``pose`` takes them, radians; roll 0 where x points straight up or down.

    Roll and yaw turn about the same line there, so that only their sum or difference is known.
    """
    level = float(np.hypot(T[0, 0], T[1, 0]))
    pitch = float(np.arctan2(-T[2, 0], level))
    if level < 1e-9:
        return 0.0, pitch, float(np.arctan2(-T[0, 1], T[1, 1]))
    return float(np.arctan2(T[2, 1], T[2, 2])), pitch, float(np.arctan2(T[1, 0], T[0, 0]))


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

"""Robots from a table of Denavit-Hartenberg parameters: their joints, and rods around their lengths as bodies."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from robotcell.robot.robot import Body, Capsule, Joint, JointKind, Poses, Robot, pose

Convention: TypeAlias = Literal["standard", "modified"]
_SHORTEST_M = 1e-6
"""Lengths below have no rod."""


@dataclass(frozen=True, slots=True)
class DhRow:
    """One joint of a table. Metres, radians."""

    name: str
    kind: JointKind
    theta: float
    """Turn about the joint's z at zero; what the joint turns by is added."""
    d: float
    """Way along the joint's z at zero; what the joint slides by is added."""
    a: float
    """Way along x: to the next joint's axis, in the modified convention from the one before."""
    alpha: float
    """Turn about x that goes with ``a``."""
    radius: float
    """Of the rods around ``d`` and ``a``."""


def build_dh_robot(name: str, convention: Convention, rows: Sequence[DhRow], T_last_flange: Poses) -> Robot:
    """Build a robot whose joints turn about or slide along the z axes of a table, in SI units.

    With Rz, Tz, Tx, Rx the turns and ways of a row, a step is Rz Tz Tx Rx in the standard convention, that of Denavit
    and Hartenberg, and Rx Tx Rz Tz in the modified one, that of Craig. Speeds, accelerations and limits are infinite
    until something else states them.

    Args:
        name: Of the robot.
        convention: Of the table.
        rows: One for each joint, base first.
        T_last_flange: (4, 4) the flange in the frame in which the table ends.
    """
    joints: list[Joint] = []
    bodies: list[list[Body]] = [[]]
    carried, radius = np.eye(4), rows[0].radius  # the frame before the next joint, on the link that carries it
    for row in rows:
        along, across = pose((0, 0, row.d), (0, 0, row.theta)), pose((row.a, 0, 0), (row.alpha, 0, 0))
        before, after = (across, along) if convention == "modified" else (np.eye(4), along @ across)
        if convention == "modified":
            bodies[-1] += _rod(joints[-1].name if joints else "base", carried, (row.a, 0.0, 0.0), row.radius)
        joints.append(
            Joint(row.name, row.kind, carried @ before, np.array([0.0, 0.0, 1.0]), -np.inf, np.inf, np.inf, np.inf)
        )
        bodies.append(_rod(row.name, np.eye(4), (0.0, 0.0, row.d), row.radius))
        if convention == "standard":
            bodies[-1] += _rod(row.name, along, (row.a, 0.0, 0.0), row.radius)
        carried, radius = after, row.radius
    x, y, z = T_last_flange[:3, 3].tolist()
    bodies[-1] += _rod(rows[-1].name, carried, (x, y, z), radius)
    return Robot(name, tuple(joints), carried @ T_last_flange, tuple(tuple(each) for each in bodies))


def _rod(name: str, T_link_start: Poses, way: tuple[float, float, float], radius: float) -> list[Body]:
    """Give the rod along a way from a frame of its link; none where the way has no length."""
    length = float(np.linalg.norm(way))
    if length < _SHORTEST_M:
        return []
    x, y, z = (each / length for each in way)
    turned = pose([0.5 * each for each in way], (0.0, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)))
    return [Body(name, Capsule(radius, length), T_link_start @ turned)]

"""Poses from what people and URDF files write: a place, and turns about fixed x, y, z."""

from collections.abc import Sequence

import numpy as np

from robotcell.robot.robot import Poses


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

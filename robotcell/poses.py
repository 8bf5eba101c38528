"""Poses from what people and URDF files write: a place, and turns about fixed x, y, z."""

from collections.abc import Sequence

import numpy as np

from robotcell.robot import Poses


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

"""Bodies as triangles, to be drawn. Metres."""

import numpy as np

from geometry.arrays import Triangles
from robotcell.robot.robot import Body, Box, Capsule

_SIDES, _RINGS = 32, 8
_FACES = np.array([
    [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
    [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
])  # fmt: skip
"""Triangles of a box, counterclockwise seen from outside; corner k is at (k & 1, k & 2, k & 4)."""


def placed_triangles(body: Body) -> Triangles:
    """(n, 3, 3) surface of a body in the frame of its carrier, metres."""
    shape, place = body.shape, body.T_carrier_shape
    match shape:
        case Box():
            signs = np.array([[(k & 1) * 2 - 1, (k & 2) - 1, (k & 4) / 2 - 1] for k in range(8)])
            triangles = (signs * np.array(shape.size) / 2)[_FACES]
        case Capsule():
            triangles = _capsule_triangles(shape.radius, shape.length)
        case _:
            triangles = shape.triangles
    return triangles @ place[:3, :3].T + place[:3, 3]


def _capsule_triangles(radius: float, length: float) -> Triangles:
    """Two hemispheres and a cylinder: rings of corners from the lower pole to the upper one."""
    rise = np.linspace(-np.pi / 2, np.pi / 2, 2 * _RINGS)
    lift = np.where(rise < 0, -length / 2, length / 2)
    around = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    corners = np.concatenate(
        [
            np.broadcast_to(radius * np.cos(rise)[:, None, None] * ring, (len(rise), _SIDES, 2)),
            np.broadcast_to((radius * np.sin(rise) + lift)[:, None, None], (len(rise), _SIDES, 1)),
        ],
        axis=2,
    )
    low, high = corners[:-1], corners[1:]
    low_next, high_next = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    halves = [np.stack([low, low_next, high_next], axis=2), np.stack([low, high_next, high], axis=2)]
    return np.concatenate([half.reshape(-1, 3, 3) for half in halves])

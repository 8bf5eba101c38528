"""Orientations as quaternions: w, x, y, z, unit length, of T_board_tool (the tool seen from the board).

Tool +Z is the jet (``approach``), tool +X the nozzle's reference azimuth. ``q`` and ``-q`` are the same orientation;
between two of them everything here goes the short way.
"""

import numpy as np

from geometry.arrays import Directions, Quaternions, Scalars

_HALF_TURN = 1e-9
"""Below this |dot| of two quaternions they are half a turn apart and both ways are equally short."""


def quaternions_from_axes(approach: Directions, reference: Directions) -> Quaternions:
    """Give the orientations whose tool +Z is ``approach`` and whose tool +X is ``reference``, both (n, 3).

    Neighbours have the sign that makes their dot product positive; the first has its first component that is not
    zero positive.
    """
    if len(approach) == 0:
        return np.empty((0, 4))
    from scipy.spatial.transform import Rotation

    axes = np.stack((reference, np.cross(approach, reference), approach), axis=-1)
    return align_signs(np.asarray(Rotation.from_matrix(axes).as_quat(scalar_first=True), dtype=np.float64))


def align_signs(quaternions: Quaternions) -> Quaternions:
    """Choose the sign of each quaternion (n, 4) that continues the one before it."""
    if len(quaternions) == 0:
        return quaternions
    start, end = quaternions[:-1], quaternions[1:]
    w = np.einsum("ij,ij->i", start, end)
    seen = start[:, :1] * end[:, 1:] - end[:, :1] * start[:, 1:] - np.cross(start[:, 1:], end[:, 1:])
    # Half a turn is as long both ways: the way is then taken from the turn as the tool itself sees it, so that it does
    # not depend on where the board lies or on the last bits.
    is_short = np.where(np.abs(w) > _HALF_TURN, w > 0.0, _leading_sign(seen) > 0.0)
    flips = np.concatenate((_leading_sign(quaternions[:1]), np.where(is_short, 1.0, -1.0)))
    return quaternions * np.cumprod(flips)[:, None]


def slerp(start: Quaternions, end: Quaternions, fraction: Scalars) -> Quaternions:
    """Turn from ``start`` towards ``end``, pair by pair (n, 4), at a constant rate about a fixed axis.

    Shoemake, "Animating rotation with quaternion curves" (1985). ``end`` keeps the sign it has if it is not more
    than half a turn away.
    """
    dot = np.einsum("ij,ij->i", start, end)
    end = np.where((dot < -_HALF_TURN)[:, None], -end, end)
    half_angle = 0.5 * rotation_angles(start, end)
    sine = np.sin(half_angle)
    wide = sine > 1e-9
    divisor = np.where(wide, sine, 1.0)
    from_start = np.where(wide, np.sin((1.0 - fraction) * half_angle) / divisor, 1.0 - fraction)
    from_end = np.where(wide, np.sin(fraction * half_angle) / divisor, fraction)
    mixed = from_start[:, None] * start + from_end[:, None] * end
    return mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


def rotation_angles(start: Quaternions, end: Quaternions) -> Scalars:
    """Give the angle between orientations, pair by pair: radians, 0 to pi."""
    return np.linalg.norm(rotation_vectors(start, end), axis=1)


def rotation_vectors(start: Quaternions, end: Quaternions) -> Directions:
    """Give axis times angle (n, 3), in the board frame and radians, of the short turn from ``start`` to ``end``."""
    w = np.einsum("ij,ij->i", start, end)
    axis = start[:, :1] * end[:, 1:] - end[:, :1] * start[:, 1:] - np.cross(end[:, 1:], start[:, 1:])
    axis = np.where((w < -_HALF_TURN)[:, None], -axis, axis)
    sine = np.linalg.norm(axis, axis=1)
    angle = 2.0 * np.arctan2(sine, np.abs(w))
    return axis * np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)[:, None]


def _leading_sign(rows: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> Scalars:
    """Sign of the first component of each row that is not zero (1 where all are)."""
    significant = np.abs(rows) > 1e-6
    leading = rows[np.arange(len(rows)), np.argmax(significant, axis=1)]
    return np.where(leading < 0.0, -1.0, 1.0)

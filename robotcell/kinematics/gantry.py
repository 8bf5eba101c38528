"""Both configurations of a gantry that carries its nozzle by three straight axes and tilts it by two turning ones.

Five axes bring the orifice to a place and the jet into a direction. How the nozzle is turned about the jet then
follows.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcell.errors import CellError
from robotcell.kinematics.chain import Zero
from robotcell.kinematics.subproblems import FREE, SLACK
from robotcell.robot.robot import Joints, Poses, Robot, flange_poses

Vectors = NDArray[np.float64]  # (n, 3)
Values = NDArray[np.float64]  # (n,)


class Gantry(NamedTuple):
    """Three straight axes, then two that turn. The base frame, metres."""

    zero: Zero
    straight: NDArray[np.float64]
    """(3, 3) the joints' way to a place."""


def recognise_gantry(zero: Zero) -> Gantry | None:
    """Give the gantry if three straight axes span space and two others turn about different directions."""
    along = zero.axes[:3].T
    tilting = float(np.linalg.norm(np.cross(zero.axes[3], zero.axes[4])))
    if abs(np.linalg.det(along)) < 1e-3 or tilting < 1e-3:
        return None
    return Gantry(zero, np.linalg.inv(along).astype(np.float64))


def solve_gantry(gantry: Gantry, robot: Robot, poses: Poses, T_flange_tcp: Poses) -> tuple[Joints, Values]:
    """Give the joints (n, 2, 5), tilted one way and the other, and the azimuths (n, 2) that come of it.

    Where the jet lies along the first turning axis, that axis turns freely: the first branch takes the
    requested azimuth, the second the opposite one.

    Raises:
        CellError: the jet lies along the last axis, which then cannot tilt it.
    """
    requested = poses @ T_flange_tcp
    tip = gantry.zero.flange @ T_flange_tcp
    swing, tilt = gantry.zero.axes[3:]
    if np.linalg.norm(_cross(tilt, tip[:3, 2])) < 1e-3:
        raise CellError(
            f"The jet lies along {robot.joints[4].name}, which cannot tilt it. Mount the tool across that axis."
        )
    rows = np.full((len(poses), 2, 5), np.nan)
    for side in range(2):
        second = _tilts(swing, tilt, tip[:3, 2], requested[:, :3, 2], 1.0 - 2.0 * side)
        first = _swings(gantry.zero, tip, requested, second)
        first += np.where(_is_along(swing, requested[:, :3, 2]), side * np.pi, 0.0)
        rows[:, side, 3], rows[:, side, 4] = _wrapped(first), _wrapped(second)
        turned = _turned(tilt, second, tip[:3, 3] - gantry.zero.points[4]) + gantry.zero.points[4]
        turned = _turned(swing, first, turned - gantry.zero.points[3]) + gantry.zero.points[3]
        rows[:, side, :3] = (requested[:, :3, 3] - turned) @ gantry.straight.T
    apart = np.abs(rows[:, 0] - rows[:, 1])
    apart[:, 3:] = np.minimum(apart[:, 3:], 2.0 * np.pi - apart[:, 3:])
    rows[np.all(apart < 1e-6, axis=1), 1] = np.nan  # the second branch is the first
    x = (flange_poses(robot, rows.reshape(-1, 5)) @ T_flange_tcp)[:, :3, 0].reshape(len(rows), 2, 3)
    along, across = (np.einsum("nbi,ni->nb", x, requested[:, :3, axis]) for axis in (0, 1))
    return rows, np.arctan2(across, along)


def _tilts(swing: Values, tilt: Values, jet: Values, jets: Vectors, sign: float) -> Values:
    """Angles (n,) of the last axis, NaN where the jet cannot be tilted so far."""
    level, across = (swing @ tilt) * (tilt @ jet), swing @ _cross(tilt, jet)
    even = swing @ jet - level
    most = float(np.hypot(even, across))
    share = jets @ swing - level
    left = (most - np.abs(share)) * (most + np.abs(share))
    if most > 1.0 - SLACK:  # the jet can lie along the first axis: there the difference would lose its digits
        left = np.sum(_cross(jets, swing) ** 2, axis=1)
    left = np.where(left < -SLACK, np.nan, np.maximum(left, 0.0))
    return np.arctan2(across, even) + sign * np.arctan2(np.sqrt(left), share)


def _swings(zero: Zero, tip: Poses, requested: Poses, second: Values) -> Values:
    """Angles (n,) of the first turning axis: from the jet, or from the azimuth where the jet lies along the axis."""
    axis = zero.axes[3]
    now = _turned(zero.axes[4], second, tip[:3, 2])
    free = _is_along(axis, requested[:, :3, 2])
    now = np.where(free[:, None], _turned(zero.axes[4], second, tip[:3, 0]), now)
    goal = np.where(free[:, None], requested[:, :3, 0], requested[:, :3, 2])
    now, goal = _cross(axis, now), _cross(axis, goal)  # what lies across the axis, however little it is
    return np.arctan2(_cross(now, goal) @ axis, np.sum(now * goal, axis=1))


def _is_along(axis: Values, jets: Vectors) -> NDArray[np.bool_]:
    return np.linalg.norm(_cross(jets, axis), axis=1) < FREE


def _turned(axis: Values, angles: Values, vectors: Vectors | Values) -> Vectors:
    """Vectors (n, 3) or (3,) turned about an axis; Rodrigues' formula."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    along = np.sum(vectors * axis, axis=-1, keepdims=True) * axis
    return along + c * (vectors - along) + s * _cross(axis, vectors)


def _wrapped(angles: Values) -> Values:
    """The same angles in (-pi, pi]."""
    return angles - 2.0 * np.pi * np.ceil((angles - np.pi) / (2.0 * np.pi))


def _cross(one: Vectors | Values, other: Vectors | Values) -> NDArray[np.float64]:
    """The same as ``np.cross``, which takes longer to arrange the axes of few vectors than to multiply them."""
    x, y, z = one[..., 0], one[..., 1], one[..., 2]
    u, v, w = other[..., 0], other[..., 1], other[..., 2]
    return np.stack((y * w - z * v, z * u - x * w, x * v - y * u), axis=-1)

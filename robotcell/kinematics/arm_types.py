"""Types of six-axis arms, recognised by their axes: which closed form gives the joints.

Both forms of six axes share the plan of their first three joints: axis 2 stands across axis 1, and axis 3 is parallel
to axis 2. In the *plane frame* x and y span the plane the arm bends in at zero, y is axis 1 and z is axis 2, so that
joint 1 turns about y and the bending joints turn about z. The *wrist frame* rides on the flange: its origin is where
the last axes meet, its z the last axis.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robotcell.kinematics.chain import Zero
from robotcell.robot.robot import Poses

ALIKE = 1e-5
"""rad and m: by how much axes may miss being parallel, square or meeting: URDF files round pi / 2 to 1.5708"""


class Bend(NamedTuple):
    """Two links that turn about parallel axes. The plane frame, metres."""

    first: tuple[float, float]
    """Where the first of the two axes stands."""
    lengths: tuple[float, float]
    angles: tuple[float, float]
    """rad, of both links against x at zero."""


class SphericalArm(NamedTuple):
    """Axes 4, 5 and 6 meet in a point and stand square: KUKA, ABB, FANUC, Yaskawa, Staubli and many others."""

    T_plane_base: Poses
    T_flange_wrist: Poses
    aside: float
    """m, how far the wrist's centre lies along axis 2, seen from axis 1."""
    bend: Bend
    signs: NDArray[np.float64]
    """(6,) +1 or -1: whether a joint counts along or against the form's own axis."""
    wrist: NDArray[np.float64]
    """(3, 3) at zero, in the plane frame: z axis 4, y axis 5."""
    tilt: float
    """rad, of axis 6 against axis 4 at zero, about axis 5."""


class ParallelArm(NamedTuple):
    """Axes 2, 3 and 4 are parallel, 5 stands across 4, and 6 across 5, which it meets.

    Universal Robots, many similar arms, and the Cairo arm.
    """

    T_plane_base: Poses
    T_flange_wrist: Poses
    aside: float
    """m, how far the meeting point of axes 5 and 6 lies along axis 2, seen from axis 1."""
    bend: Bend
    """From axis 2 by axis 3 to axis 4."""
    signs: NDArray[np.float64]
    """(6,) +1 or -1"""
    last: tuple[float, float]
    """m, from axis 4 to the meeting point, in the plane, at zero."""
    turn: float
    """rad, of axis 5 against y at zero, about axis 2."""
    tilt: float
    """rad, of axis 6 against axis 4 at zero, about axis 5."""


SixAxis: TypeAlias = SphericalArm | ParallelArm


def recognise(zero: Zero) -> SixAxis | None:
    """Give the closed form that fits an arm of six turning axes, if any does."""
    h = zero.axes
    if not (_square(h[0], h[1]) and _parallel(h[1], h[2]) and _square(h[3], h[4]) and _square(h[4], h[5])):
        return None
    centre = _meeting(zero, 4, 5)
    if centre is None:
        return None
    parallel = _parallel(h[1], h[3])
    above = centre if parallel else _meeting(zero, 3, 4)
    if above is None or np.linalg.norm(above - centre) > ALIKE:
        return None
    plane = np.eye(4)
    y, z = h[0], h[1] - (h[1] @ h[0]) * h[0]
    z /= np.linalg.norm(z)
    plane[:3, :3], plane[:3, 3] = np.stack((np.cross(y, z), y, z), axis=1), zero.points[0]
    return _fit(zero, plane, centre, parallel=parallel)


def _fit(zero: Zero, T_base_plane: Poses, centre: NDArray[np.float64], *, parallel: bool) -> SixAxis | None:
    """Give the numbers of the closed form, or ``None`` if a link has no length."""
    turn, origin = T_base_plane[:3, :3], T_base_plane[:3, 3]
    axes, points, goal = zero.axes @ turn, (zero.points - origin) @ turn, (centre - origin) @ turn
    links = (points[2] - points[1])[:2], ((points[3] if parallel else goal) - points[2])[:2]
    lengths = float(np.hypot(*links[0])), float(np.hypot(*links[1]))
    if min(lengths) < ALIKE:
        return None
    angles = float(np.arctan2(links[0][1], links[0][0])), float(np.arctan2(links[1][1], links[1][0]))
    bend = Bend((float(points[1, 0]), float(points[1, 1])), lengths, angles)
    y, z = axes[4], np.array([0.0, 0.0, 1.0]) if parallel else axes[3]
    wrist = np.stack((np.cross(y, z), y, z), axis=1)
    along = wrist.T @ axes[5]
    tilt = float(np.arctan2(along[0], along[2]))
    c, s = np.cos(tilt), np.sin(tilt)
    T_plane_wrist = np.eye(4)  # its rotation at zero is that of the wrist, tilted about its y
    T_plane_wrist[:3, :3] = wrist @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    T_plane_wrist[:3, 3] = goal
    T_flange_wrist = np.linalg.inv(zero.flange) @ T_base_plane @ T_plane_wrist
    T_plane_base, aside = np.linalg.inv(T_base_plane).astype(np.float64), float(goal[2])
    signs = np.array([1.0, 1.0, np.sign(axes[2, 2]), np.sign(axes[3, 2]) if parallel else 1.0, 1.0, 1.0])
    if not parallel:
        return SphericalArm(T_plane_base, T_flange_wrist, aside, bend, signs, wrist, tilt)
    last = (float(goal[0] - points[3, 0]), float(goal[1] - points[3, 1]))
    azimuth = float(np.arctan2(-y[0], y[1]))
    return ParallelArm(T_plane_base, T_flange_wrist, aside, bend, signs, last, azimuth, tilt)


def _parallel(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return bool(np.linalg.norm(np.cross(a, b)) < ALIKE)


def _square(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return bool(abs(a @ b) < ALIKE)


def _meeting(zero: Zero, one: int, other: int) -> NDArray[np.float64] | None:
    """The point where two axes that are not parallel meet, or None if they pass each other."""
    (a, b), (p, r) = zero.axes[[one, other]], zero.points[[one, other]]
    across = np.cross(a, b)
    apart = r - p
    if abs(apart @ across) > ALIKE * np.linalg.norm(across):
        return None
    square = across @ across
    on_a = p + a * (np.cross(apart, b) @ across / square)
    on_b = r + b * (np.cross(apart, a) @ across / square)
    return (on_a + on_b) / 2.0

"""A robot as a chain for compiled loops: flange pose, Jacobian, manipulability, polishing of IK solutions."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.compiled import compiled, inner
from robotcell.robot.robot import Joints, Poses, Robot, flange_poses, link_poses

Row: TypeAlias = NDArray[np.float64]  # (dof,)
Matrix: TypeAlias = NDArray[np.float64]  # (3, 3) unless stated


EXACT = 1e-8
"""m + rad: what is nearer is left as it is. Closed forms are; the axes of a rounded URDF file are not quite square"""
ACCEPTED = 5e-7
"""m + rad: what is farther is no solution"""
SAME = 1e-6
"""rad or m: rows that differ by less in every joint are one; where branches meet, a root's rounding is most of it"""
DAMPING = 1e-8
"""Of the normal equations, whose unit is a metre and a radian: keeps steps at singular poses short"""
MOST_STEPS = 8


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
        away, helper = np.eye(4), np.zeros(3)  # a rotation that takes z to the axis; its x is arbitrary
        helper[np.argmin(np.abs(joint.axis))] = 1.0
        x = np.cross(helper, joint.axis)
        x /= np.linalg.norm(x)
        away[:3, :3] = np.stack((x, np.cross(joint.axis, x), joint.axis), axis=1)
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


@compiled
def flange_at(steps: Poses, turns: NDArray[np.bool_], q: Row, pose: Poses) -> None:
    """Write the flange's pose (4, 4) at one row of joints."""
    pose[:] = steps[0]
    moved = np.empty((3, 4))
    for joint in range(len(turns)):
        step_over(pose, turns[joint], q[joint])
        add_step(pose, steps[joint + 1], moved)


@inner
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


@inner
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
def write_jacobian(
    steps: Poses, turns: NDArray[np.bool_], q: Row, pose: Poses, frames: NDArray[np.float64], out: Matrix
) -> None:
    """Write the flange's pose (4, 4) and its geometric Jacobian (6, dof) at one row of joints.

    The ``frames`` (dof + 1, 3, 4) are scratch.
    """
    dof = len(turns)
    pose[:] = steps[0]
    for joint in range(dof):
        frames[joint] = pose[:3]
        step_over(pose, turns[joint], q[joint])
        add_step(pose, steps[joint + 1], frames[dof])
    for joint in range(dof):
        x, y, z = frames[joint, 0, 2], frames[joint, 1, 2], frames[joint, 2, 2]
        if turns[joint]:
            a, b, c = (
                pose[0, 3] - frames[joint, 0, 3],
                pose[1, 3] - frames[joint, 1, 3],
                pose[2, 3] - frames[joint, 2, 3],
            )
            out[0, joint], out[1, joint], out[2, joint] = y * c - z * b, z * a - x * c, x * b - y * a
            out[3, joint], out[4, joint], out[5, joint] = x, y, z
        else:
            out[0, joint], out[1, joint], out[2, joint] = x, y, z
            out[3:, joint] = 0.0


@compiled
def manipulability(steps: Poses, turns: NDArray[np.bool_], q: Joints) -> Scalars:
    """Give |det J| (m,) of six-axis configurations (m, 6); it does not depend on where the tool's tip is.

    Yoshikawa, "Manipulability of robotic mechanisms" (1985), for a square Jacobian.
    """
    dof = len(turns)
    result = np.empty(len(q))
    pose, frames, jacobian = np.empty((4, 4)), np.empty((dof + 1, 3, 4)), np.empty((6, dof))
    for row in range(len(q)):
        write_jacobian(steps, turns, q[row], pose, frames, jacobian)
        result[row] = abs(np.linalg.det(jacobian))
    return result


@compiled
def polish_rows(chain: Chain, poses: Poses, rows: Joints) -> None:
    """Improve rows (n, b, dof) in place and drop (NaN) what misses its pose (n, 4, 4) or is there already.

    Turning joints come to lie in (-pi, pi].
    """
    for number in range(len(poses)):
        for index in range(rows.shape[1]):
            q = rows[number, index]
            if math.isnan(q[0]):
                continue
            # "not <=" so that a pose of NaN is no pose
            if not _improve(chain, poses[number], q) <= ACCEPTED:
                q[:] = np.nan
                continue
            for joint in range(len(q)):
                if chain.turns[joint]:
                    q[joint] -= 2.0 * math.pi * math.ceil((q[joint] - math.pi) / (2.0 * math.pi))
            if _is_known(chain.turns, rows[number, :index], q):
                q[:] = np.nan


@inner
def _is_known(turns: NDArray[np.bool_], rows: Joints, q: Row) -> bool:
    for index in range(len(rows)):
        same = not math.isnan(rows[index, 0])
        for joint in range(len(q)):
            if not same:
                break
            apart = abs(q[joint] - rows[index, joint])
            if turns[joint]:
                apart = min(apart, 2.0 * math.pi - apart)
            same = apart < SAME
        if same:
            return True
    return False


@compiled
def _improve(chain: Chain, pose: Poses, q: Row) -> float:
    """Give by how much a row misses; improve it in place by Newton's steps if need be, never for the worse."""
    here = np.empty((4, 4))
    flange_at(chain.steps, chain.turns, q, here)
    miss = _miss(here, pose)
    if not (EXACT < miss < 0.1):
        return miss
    best = q.copy()
    trial = q.copy()
    for _ in range(MOST_STEPS):
        trial += _newton(chain, pose, here, trial)
        flange_at(chain.steps, chain.turns, trial, here)
        now = _miss(here, pose)
        if not now < miss:
            break
        miss = now
        best[:] = trial
        if miss < EXACT * 1e-3:
            break
    q[:] = best
    return miss


@inner
def _miss(here: Poses, pose: Poses) -> float:
    """Metres and radians between two poses (4, 4), added up. The chord of a turn: twice the sine of half its angle."""
    along, turned = 0.0, 0.0
    for row in range(3):
        along += (here[row, 3] - pose[row, 3]) ** 2
        for column in range(3):
            turned += (here[row, column] - pose[row, column]) ** 2
    return math.sqrt(along) + math.sqrt(turned / 2.0)


@compiled
def _newton(chain: Chain, pose: Poses, here: Poses, q: Row) -> Row:
    """Give the damped Newton step (dof,) that brings the flange from where it is towards a pose."""
    twist = np.zeros(6)
    for axis in range(3):
        twist[axis] = pose[axis, 3] - here[axis, 3]
    for column in range(3):
        for axis in range(3):
            one, two = (axis + 1) % 3, (axis + 2) % 3
            twist[3 + axis] += (here[one, column] * pose[two, column] - here[two, column] * pose[one, column]) / 2.0
    dof = len(q)
    frames, slopes = np.empty((dof + 1, 3, 4)), np.empty((6, dof))
    write_jacobian(chain.steps, chain.turns, q, np.empty((4, 4)), frames, slopes)
    square, right = np.zeros((dof, dof)), np.zeros(dof)
    for one in range(dof):
        for axis in range(6):
            right[one] += slopes[axis, one] * twist[axis]
            for two in range(dof):
                square[one, two] += slopes[axis, one] * slopes[axis, two]
        square[one, one] += DAMPING
    step = np.empty(dof)
    step[:] = np.linalg.solve(square, right)
    return step


ALIKE = 1e-5
"""rad and m: by how much axes may miss being parallel, square or meeting: URDF files round pi / 2 to 1.5708"""


class Bend(NamedTuple):
    """Two links that turn about parallel axes. The plane frame, metres."""

    first: tuple[float, float]
    """Where the first of the two axes stands."""
    lengths: tuple[float, float]
    angles: tuple[float, float]
    """rad, of both links against x at zero."""


class SixAxis(NamedTuple):
    """An arm of six turning axes that has a closed form.

    Either axes 2, 3 and 4 are parallel, 5 stands across 4, and 6 across 5, which it meets: Universal Robots, many
    similar arms, and the Cairo arm. Or axes 4, 5 and 6 meet in a point and stand square, a spherical wrist: KUKA, ABB,
    FANUC, Yaskawa, Staubli and many others.
    """

    is_parallel: bool
    """Whether it is the first."""
    T_plane_base: Poses
    T_flange_wrist: Poses
    aside: float
    """m, how far the wrist's centre, or the meeting point of axes 5 and 6, lies along axis 2, seen from axis 1."""
    bend: Bend
    """To the wrist's centre; of parallel axes from axis 2 by axis 3 to axis 4."""
    signs: NDArray[np.float64]
    """(6,) +1 or -1: whether a joint counts along or against the form's own axis."""
    tilt: float
    """rad, of axis 6 against axis 4 at zero, about axis 5."""
    wrist: NDArray[np.float64]
    """(3, 3) at zero, in the plane frame: z axis 4, y axis 5."""
    last: tuple[float, float]
    """m, of parallel axes from axis 4 to the meeting point, in the plane, at zero."""
    turn: float
    """rad, of parallel axes that of axis 5 against y at zero, about axis 2."""


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
    last = (float(goal[0] - points[3, 0]), float(goal[1] - points[3, 1]))
    turned = float(np.arctan2(-y[0], y[1]))
    return SixAxis(parallel, T_plane_base, T_flange_wrist, aside, bend, signs, tilt, wrist, last, turned)


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

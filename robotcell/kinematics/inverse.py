"""Inverse kinematics: every configuration that brings the flange to a pose, in bulk. Metres, radians.

A gantry carries its nozzle by three straight axes and tilts it by two turning ones: five axes bring the orifice to a
place and the jet into a direction, and how the nozzle is turned about the jet then follows.

Six turning axes that fit no closed form of ours are solved by libraries. EAIK solves three parallel axes and wrists
whose axes meet, at any angles, in bulk; at singular poses it loses configurations. ssik solves every arm, a hundred
times slower: where EAIK has no solution or may have lost some.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias, assert_never, cast

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices
from robotcell.errors import CellError
from robotcell.kinematics.chain import Chain, SixAxis, Zero, chain_of, polish_rows, recognise, zero_of
from robotcell.kinematics.closed_forms import FREE, SLACK, solve_six_axis
from robotcell.robot.robot import Joints, Poses, Robot, flange_poses, singularity

MOST_BRANCHES = 16
"""No arm of six turning joints has more configurations (Raghavan and Roth 1990)"""
NEARLY_SINGULAR = 1e-3
"""Inverse condition: what EAIK finds nearer to a singular pose may not be all"""


class GeneralArm(NamedTuple):
    """An arm whose axes fit no closed form of our own."""

    robot: Robot
    bulk: Any
    """An eaik HomogeneousRobot, or None where EAIK has no decomposition."""
    sure: Any
    """An ssik.Manipulator."""


def prepare_general(robot: Robot, chain: Chain) -> GeneralArm:
    """Prepare EAIK and ssik; for the most general arms this takes ssik a minute, once in a user's cache.

    Raises:
        CellError: they are missing, or have no closed form.
    """
    try:
        import ssik
        from eaik.IK_Homogeneous import HomogeneousRobot
    except ImportError as missing:
        raise CellError(
            f"The joints of {robot.name} are found by EAIK and ssik. It needs `pip install washboard[robot]`."
        ) from missing
    world = np.array([chain.steps[0]] * len(chain.steps))
    for index in range(1, len(chain.steps)):
        world[index] = world[index - 1] @ chain.steps[index]
    bulk = cast(Any, HomogeneousRobot)(world)
    try:
        sure = cast(Any, ssik.Manipulator).from_transforms(chain.steps)
        sure.prepare()
    except (ValueError, NotImplementedError, RuntimeError) as error:
        raise CellError(f"There is no closed form for the joints of {robot.name}: ssik reports: {error}") from error
    return GeneralArm(robot, bulk if bulk.hasKnownDecomposition() else None, sure)


def solve_general(arm: GeneralArm, chain: Chain, poses: Poses, rows: Joints) -> None:
    """Write the rows (n, 16, 6) that bring the flange to poses (n, 4, 4), ordered by joint 1, then 2 and so on.

    At singular poses they are those that ssik picks out of a continuum.
    """
    rows[:] = np.nan
    doubtful = np.all(np.isfinite(poses), axis=(1, 2))
    if arm.bulk is not None:
        known = np.flatnonzero(doubtful)
        for index, found in zip(known, arm.bulk.IK_batched(poses[known], 1), strict=True):
            _polish_found(chain, poses[index], found.Q, rows[index])
        # configurations may be lost: none, an odd number, or one that is nearly singular
        real = ~np.isnan(rows[known, :, 0])
        inverse_condition = np.ones(real.shape)
        if np.any(real):
            inverse_condition[real] = singularity(arm.robot, rows[known][real])[1]
        count = np.sum(real, axis=1)
        doubtful[known] = (count % 2 == 1) | (count == 0) | np.any(inverse_condition < NEARLY_SINGULAR, axis=1)
    for index in np.flatnonzero(doubtful):
        found = arm.sure.solve(poses[index], respect_limits=False, enumerate_windings=False)
        _polish_found(chain, poses[index], [one.q for one in found], rows[index])


def _polish_found(chain: Chain, pose: Poses, found: Any, rows: Joints) -> None:
    """Write what was found for a pose and is true, in order."""
    rows[:] = np.nan
    joints = np.array(found, dtype=np.float64).reshape(-1, 6)[:MOST_BRANCHES]
    rows[: len(joints)] = joints
    polish_rows(chain, pose[None], rows[None])
    rows[:] = rows[np.lexsort(np.round(rows, 6).T[::-1])]


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


Form: TypeAlias = SixAxis | Gantry | GeneralArm


@dataclass(frozen=True, slots=True, eq=False)
class Kinematics:
    """The closed form of a robot, recognised once by its axes."""

    chain: Chain
    form: Form
    branches: int
    """The greatest number of configurations of a pose."""


@dataclass(frozen=True, slots=True, eq=False)
class Solutions:
    """All configurations that bring the flange to n poses, whatever the joint limits."""

    q: Joints
    """(n, branches, dof) turning joints in (-pi, pi]; NaN where a branch has none.

    Of closed forms a branch keeps its index: 4 shoulder + 2 elbow + wrist for arms, the way of tilting for gantries.
    """
    count: Indices
    """(n,) how many there are."""
    azimuth: NDArray[np.float64]
    """(n, branches) by how much the tool is turned about its jet beyond the requested azimuth; 0 but for gantries."""


@lru_cache(maxsize=16)
def kinematics_of(robot: Robot) -> Kinematics:
    """Give the closed form of a robot; it is cached by robot.

    Raises:
        CellError: no closed form is known for such a robot.
    """
    kinds = "".join("T" if joint.kind == "revolute" else "S" for joint in robot.joints)
    chain = chain_of(robot)
    if kinds == "TTTTTT":
        arm = recognise(zero_of(robot))
        if arm is not None:
            return Kinematics(chain, arm, 8)
        return Kinematics(chain, prepare_general(robot, chain), MOST_BRANCHES)
    gantry = recognise_gantry(zero_of(robot)) if kinds == "SSSTT" else None
    if gantry is not None:
        return Kinematics(chain, gantry, 2)
    known = "Known are arms of six turning joints, and gantries of three straight joints followed by two turning ones."
    if kinds == "SSSTT":
        reason = f"{robot.name}: its straight joints do not span space, or its turning joints are parallel."
    else:
        joints = f"{kinds.count('T')} turning and {kinds.count('S')} straight joints"
        free = " More than six leave the pose undetermined." if len(kinds) > 6 else ""
        reason = f"There is no closed form for {robot.name} with its {joints}.{free}"
    raise CellError(f"{reason} {known}")


def gantry_of(robot: Robot) -> Gantry | None:
    """Give a robot's closed form if it is a gantry of three straight joints followed by two turning ones.

    Raises:
        CellError: no closed form is known for such a robot.
    """
    form = kinematics_of(robot).form
    return form if isinstance(form, Gantry) else None


def solve(
    robot: Robot, T_base_flange: Poses, *, T_flange_tcp: Poses | None = None, preferred: Joints | None = None
) -> Solutions:
    """Find every configuration that brings the flange to each of n poses.

    Six axes reach a pose as it is. Five reach the tool's place and the direction of its jet (tool +Z), and the azimuth
    follows: see ``Solutions.azimuth``. At a singular pose, where a joint turns freely, the branches take the preferred
    angle of that joint and its opposite (three parallel axes: the nearest to these with most configurations).

    Args:
        robot: The robot.
        T_base_flange: (n, 4, 4) or (4, 4).
        T_flange_tcp: (4, 4) the tool, needed for gantries; the flange itself if left out.
        preferred: (dof,) or (n, dof) angles for joints that turn freely; if left out 0, or the limit nearest to it.

    Raises:
        CellError: no closed form is known for such a robot.
    """
    kinematics = kinematics_of(robot)
    poses = np.ascontiguousarray(T_base_flange, dtype=np.float64).reshape(-1, 4, 4)
    rows = np.full((len(poses), kinematics.branches, robot.dof), np.nan)
    azimuth = np.zeros(rows.shape[:2])
    match kinematics.form:
        case SixAxis() as arm:
            if preferred is None:
                preferred = np.minimum(np.maximum(0.0, robot.lowest), robot.highest)
            favoured = np.ascontiguousarray(np.broadcast_to(preferred, (len(poses), robot.dof)), dtype=np.float64)
            solve_six_axis(arm, kinematics.chain, poses, favoured, rows)
        case GeneralArm() as arm:
            solve_general(arm, kinematics.chain, poses, rows)
        case Gantry() as gantry:
            tool = np.eye(4) if T_flange_tcp is None else T_flange_tcp
            rows, azimuth = solve_gantry(gantry, robot, poses, tool)
        case _:
            assert_never(kinematics.form)
    return Solutions(rows, np.sum(~np.isnan(rows[:, :, 0]), axis=1), azimuth)

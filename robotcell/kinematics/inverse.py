"""Inverse kinematics: every configuration that brings the flange to a pose, in bulk. Metres, radians.

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
from robotcell.kinematics.chain import Chain, SixAxis, chain_of, polish_rows, recognise, zero_of
from robotcell.kinematics.closed_forms import solve_six_axis
from robotcell.kinematics.gantry import Gantry, recognise_gantry, solve_gantry
from robotcell.robot.robot import Joints, Poses, Robot, singularity

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

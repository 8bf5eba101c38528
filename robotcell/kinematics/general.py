"""Every configuration of any other arm of six turning joints, by libraries.

EAIK solves three parallel axes and wrists whose axes meet, at any angles, in bulk; at singular poses it loses
configurations. ssik solves every arm, a hundred times slower: where EAIK has no solution or may have lost some.
"""

from typing import Any, NamedTuple, cast

import numpy as np

from robotcell.errors import CellError
from robotcell.kinematics.chain import Chain, polish_rows
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

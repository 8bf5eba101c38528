"""Every configuration of any other arm of six turning joints, by ssik: exact, and a hundred times slower."""

from typing import Any, NamedTuple, cast

import numpy as np

from robotcell.errors import CellError
from robotcell.ik_chain import Chain
from robotcell.ik_settle import settle
from robotcell.robot import Joints, Poses, Robot

MOST_BRANCHES = 16
"""No arm of six turning joints has more configurations (Raghavan and Roth 1990)"""


class GeneralArm(NamedTuple):
    """An arm whose axes stand as they like."""

    solver: Any
    """An ssik.Manipulator."""


def prepare_general(robot: Robot) -> GeneralArm:
    """Let ssik find a way; for the most general arms this takes up to a minute, once in a user's cache.

    Raises:
        CellError: ssik is missing, or knows no closed form.
    """
    try:
        import ssik
    except ImportError as missing:
        raise CellError(
            f"{robot.name}: the joints of this arm are found by ssik, which needs `pip install washboard[robot]`."
        ) from missing
    frames = np.array([joint.T_parent_joint for joint in robot.joints] + [robot.T_link_flange])
    axes = np.array([joint.axis for joint in robot.joints])
    try:
        solver = cast(Any, ssik.Manipulator).from_transforms(frames, axes)
        solver.prepare()
    except (ValueError, NotImplementedError, RuntimeError) as said:
        raise CellError(f"There is no closed form for the joints of {robot.name}: ssik said: {said}") from said
    return GeneralArm(solver)


def solve_general(arm: GeneralArm, chain: Chain, poses: Poses, rows: Joints) -> None:
    """Write the rows (n, 16, 6) that bring the flange to poses (n, 4, 4), ordered by joint 1, then 2 and so on.

    At singular poses they are those that ssik picks out of a continuum.
    """
    rows[:] = np.nan
    for pose, mine in zip(poses, rows, strict=True):
        if not np.all(np.isfinite(pose)):
            continue
        found = arm.solver.solve(pose, respect_limits=False, enumerate_windings=False)
        joints = np.array([one.q for one in found]).reshape(-1, 6)[:MOST_BRANCHES]
        mine[: len(joints)] = joints
        settle(chain, pose, mine)
        mine[:] = mine[np.lexsort(np.round(mine, 6).T[::-1])]

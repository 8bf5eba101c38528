"""Arms that no closed form of ours fits are solved by libraries."""

import sys

import numpy as np
import pytest
from arms import QUARTER, UR5, apart, dh_arm, miss, random_rows, search

from robotcell.errors import CellError
from robotcell.kinematics.inverse import GeneralArm, kinematics_of, solve
from robotcell.robot.robot import Robot, flange_poses

LEANT = ((-QUARTER, 0.15, 0.5), (0, 0.6, 0), (-QUARTER, 0.1, 0))
HOLLOW = dh_arm("hollow wrist", *LEANT, (np.pi / 3, 0, 0.6), (-np.pi / 3, 0, 0), (0, 0, 0.1))
PASSING = dh_arm("passing axes", *UR5[:4], (-QUARTER, 0.05, 0.09), UR5[5])
OFFSET = dh_arm("offset wrist", (-QUARTER, 0, 0.245), (0, 0.54, 0), (-QUARTER, 0, 0), (QUARTER, 0, 0.54),
                (-QUARTER, 0, 0.15), (0, 0, 0.16))  # fmt: skip


def check(robot: Robot, count: int, q: np.ndarray) -> None:
    poses = flange_poses(robot, q)
    found = solve(robot, poses)
    real = ~np.isnan(found.q[:, :, 0])
    tips = np.repeat(poses[:, None], real.shape[1], axis=1)[real]
    assert len(q) == count
    assert np.max(miss(flange_poses(robot, found.q[real]), tips)) < 1e-6
    assert np.max(np.min(apart(robot, found.q, q[:, None]), axis=1)) < 1e-5
    for pose, mine in zip(poses[:3], found.q[:3], strict=True):
        assert all(np.min(apart(robot, mine, row)) < 1e-5 for row in search(robot, pose, 60, 1))


@pytest.mark.slow
@pytest.mark.parametrize("robot", [HOLLOW, PASSING], ids=lambda robot: robot.name)
def test_libraries_find_every_configuration(robot: Robot) -> None:
    assert isinstance(kinematics_of(robot).form, GeneralArm)
    check(robot, 100, random_rows(robot, 100, 1))


@pytest.mark.parametrize("robot", [HOLLOW, PASSING], ids=lambda robot: robot.name)
def test_ssik_is_asked_where_eaik_loses_configurations(robot: Robot) -> None:
    """With joint 5 at zero EAIK finds nothing at all for some poses of the second arm."""
    q = random_rows(robot, 100, 2)
    q[:, 4] = 0.0
    assert np.all(solve(robot, flange_poses(robot, q)).count >= 1)


@pytest.mark.slow
def test_an_arm_whose_axes_neither_meet_nor_are_parallel_enough_is_solved_too() -> None:
    """Its preparation takes up to a minute."""
    check(OFFSET, 20, random_rows(OFFSET, 20, 3))


def test_out_of_reach_there_is_nothing() -> None:
    far = np.eye(4)
    far[0, 3] = 9.0
    assert list(solve(HOLLOW, np.array([far, np.full((4, 4), np.nan)])).count) == [0, 0]


def test_without_the_libraries_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ssik", None)
    unknown = dh_arm("another", *LEANT, (np.pi / 4, 0, 0.6), (-np.pi / 4, 0, 0), (0, 0, 0.1))
    with pytest.raises(CellError, match=r"pip install washboard\[robot\]"):
        solve(unknown, np.eye(4))

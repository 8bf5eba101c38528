"""At singular poses, where libraries lose configurations, none is lost and nothing is noise."""

import numpy as np
import pytest
from arms import LIBRARY, UR5, apart, cairo, dh_arm, library_robot, miss, nudged, random_rows

from robotcell.kinematics.chain import SixAxis
from robotcell.kinematics.inverse import kinematics_of, solve
from robotcell.robot.robot import Joints, Robot, flange_poses

ARMS = [name for name in LIBRARY if library_robot(name).dof == 6]
CASES = ["wrist", "turned wrist", "elbow", "elbow and wrist", "fold", "fold and wrist", "shoulder"]
NEAR = 1e-4
"""m and rad to the poses beside a singular one"""


def form_of(robot: Robot) -> SixAxis:
    form = kinematics_of(robot).form
    assert isinstance(form, SixAxis)
    return form


def elbow_at(robot: Robot, bent: float) -> float:
    """Joint 3 where the links make that angle."""
    form = form_of(robot)
    return form.signs[2] * (bent - form.bend.angles[1] + form.bend.angles[0])


def singular_rows(robot: Robot, case: str, count: int) -> Joints:
    q = random_rows(robot, count, len(case))
    straight_wrist = -form_of(robot).tilt
    if "wrist" in case:
        q[:, 4] = straight_wrist + (np.pi if "turned" in case else 0.0)
    if "elbow" in case:
        q[:, 2] = elbow_at(robot, 0.0)
    if "fold" in case:
        q[:, 2] = elbow_at(robot, np.pi)
    return q


def over_the_shoulder(robot: Robot, count: int) -> Joints:
    """Rows whose wrist is above axis 1 or as near to it as it can be, by joint 2."""
    form, q = form_of(robot), random_rows(robot, count, 9)
    angles = np.linspace(-np.pi, np.pi, 61)
    rows = np.repeat(q, len(angles), axis=0)
    rows[:, 1] = np.tile(angles, count)
    ahead = forward(robot, form, rows).reshape(count, -1)
    crosses = np.argmax(ahead[:, 1:] * ahead[:, :-1] < 0.0, axis=1)
    low, high = angles[crosses], angles[crosses + 1]
    q = q[np.any(ahead[:, 1:] * ahead[:, :-1] < 0.0, axis=1)]
    low, high = low[: len(q)], high[: len(q)]
    for _ in range(80):
        middle = (low + high) / 2.0
        q[:, 1] = low
        here = forward(robot, form, q)
        q[:, 1] = middle
        same = forward(robot, form, q) * here > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return q


def forward(robot: Robot, form: SixAxis, rows: Joints) -> np.ndarray:
    """How far the wrist is ahead of axis 1, in the plane it bends in."""
    still = rows.copy()
    still[:, 0] = 0.0
    return (form.T_plane_base @ flange_poses(robot, still) @ form.T_flange_wrist)[:, 0, 3]


def rows_of(robot: Robot, case: str, count: int) -> Joints:
    return over_the_shoulder(robot, count) if case == "shoulder" else singular_rows(robot, case, count)


def branches(robot: Robot, found: Joints, border: float) -> tuple[np.ndarray, np.ndarray]:
    """How many branches (n,) there are away from the border of what elbow and shoulder reach, and how many on it."""
    form = form_of(robot)
    bent = form.signs[2] * found[:, :, 2] + form.bend.angles[1] - form.bend.angles[0]
    ahead = forward(robot, form, np.nan_to_num(found.reshape(-1, 6))).reshape(bent.shape)
    away = (np.abs(np.sin(bent)) > border) & ((np.abs(ahead) > border / 3.0) | (abs(form.aside) < 1e-9))
    return np.sum(away, axis=1), np.sum(~away & ~np.isnan(bent), axis=1)


def is_as_rich_as_its_neighbours(name: str, case: str, count: int, neighbours: int) -> None:
    robot = library_robot(name)
    q = rows_of(robot, case, count)
    poses = flange_poses(robot, q)
    found = solve(robot, poses)
    real = ~np.isnan(found.q[:, :, 0])
    tips = np.repeat(poses[:, None], real.shape[1], axis=1)[real]
    assert np.max(miss(flange_poses(robot, found.q[real]), tips)) < 1e-8
    assert np.all(found.count > 0)
    simple, merged = branches(robot, found.q, 1e-4)
    beside = [branches(robot, solve(robot, nudged(poses, NEAR, seed)).q, 0.1)[0] for seed in range(neighbours)]
    assert np.all(simple + 2 * merged >= np.max(beside, axis=0))


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", ARMS)
def test_singular_poses_have_as_many_configurations_as_those_beside_them(name: str, case: str) -> None:
    is_as_rich_as_its_neighbours(name, case, 800, 3)


@pytest.mark.parametrize("name", ARMS)
def test_with_all_joints_at_zero_there_are_configurations(name: str) -> None:
    robot = library_robot(name)
    pose = flange_poses(robot, np.zeros((1, 6)))
    found = solve(robot, pose)
    assert found.count[0] >= 2
    assert np.min(apart(robot, found.q[0], np.zeros(6))) < 1e-6


@pytest.mark.parametrize("name", ARMS)
def test_a_free_wrist_takes_the_preferred_angle_and_its_opposite(name: str) -> None:
    """Both branches, so that whichever way the path goes on, one of them is near."""
    robot = library_robot(name)
    free = 5 if form_of(robot).is_parallel else 3
    q = singular_rows(robot, "wrist", 50)
    poses = flange_poses(robot, q)
    found = solve(robot, poses, preferred=q)
    assert np.all(np.min(apart(robot, found.q, q[:, None]), axis=1) < 1e-6)
    straight = np.abs(np.sin(found.q[:, :, 4] + form_of(robot).tilt)) < 1e-6
    away = np.abs(np.sin(found.q[:, :, free] - q[:, None, free]))
    mine = straight & (apart(robot, found.q[:, :, :1], q[:, None, :1]) < 1e-6) if free == 3 else straight
    share = np.mean(away[mine] < 1e-6)
    assert share == 1.0 if free == 3 else share > 0.5


def test_a_free_shoulder_takes_the_preferred_angle_where_that_can_be() -> None:
    robot = cairo(0.4, 0.35, 0.08)
    q = over_the_shoulder(robot, 60)
    assert len(q) > 20
    q[:, 0] = 0.7
    found = solve(robot, flange_poses(robot, q), preferred=np.full(6, 0.7))
    assert np.all(found.count >= 2)
    assert np.mean(np.any(np.abs(found.q[:, :, 0] - 0.7) < 1e-9, axis=1)) > 0.5
    assert np.all(np.nanmin(np.abs(np.nan_to_num(found.q[:, :, 0], nan=9.0) - 0.7), axis=1) < np.pi / 2 + 1e-9)


def test_an_elbow_that_folds_onto_itself_leaves_the_shoulder_free() -> None:
    """Two links of one length: axis 4 comes to lie on axis 2."""
    robot = cairo(0.4, 0.4, 0.08)
    q = random_rows(robot, 40, 1)
    q[:, 2] = np.pi
    poses = flange_poses(robot, q)
    found = solve(robot, poses, preferred=np.full(6, 0.3))
    assert np.all(found.count >= 2)
    assert np.all(np.any(np.abs(found.q[:, :, 1] - 0.3) < 1e-9, axis=1))


@pytest.mark.parametrize("tilt", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 0.0])
def test_hardly_singular_poses_lose_no_digits(tilt: float) -> None:
    robot = dh_arm("ur5", *UR5)
    q = random_rows(robot, 200, 2)
    q[:, 4] = tilt
    poses = flange_poses(robot, q)
    found = solve(robot, poses)
    real = ~np.isnan(found.q[:, :, 0])
    assert np.all(found.count >= 2)
    assert np.max(miss(flange_poses(robot, found.q[real]), np.repeat(poses[:, None], 8, axis=1)[real])) < 3e-9


def test_where_two_branches_meet_there_is_one() -> None:
    robot = dh_arm("ur5", *UR5)
    q = random_rows(robot, 100, 3)
    q[:, 2] = 0.0
    found = solve(robot, flange_poses(robot, q)).q
    for elbow_left in (0, 1, 4, 5):
        both = ~np.isnan(found[:, elbow_left, 0]) & ~np.isnan(found[:, elbow_left + 2, 0])
        assert np.all(np.abs(found[both, elbow_left, 2]) > 1e-4)

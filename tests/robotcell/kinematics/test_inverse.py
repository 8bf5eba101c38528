"""Every configuration is found, none is wrong, and the same branch keeps its place."""

import numpy as np
import pytest
from arms import LIBRARY, UR5, apart, cairo, dh_arm, library_robot, miss, random_rows, search
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.errors import CellError
from robotcell.kinematics.inverse import Solutions, kinematics_of, solve
from robotcell.robot.robot import Joint, Poses, Robot, flange_poses, is_inside, singularity

ARMS = [name for name in LIBRARY if library_robot(name).dof == 6]
AMONG = 1e-6
"""m and rad, required of every configuration; what is measured is a thousand times less"""


def turned_about_jet(poses: Poses, azimuth: np.ndarray) -> Poses:
    turn = np.tile(np.eye(4), (*azimuth.shape, 1, 1))
    turn[..., 0, 0] = turn[..., 1, 1] = np.cos(azimuth)
    turn[..., 1, 0] = np.sin(azimuth)
    turn[..., 0, 1] = -turn[..., 1, 0]
    return poses[:, None] @ turn


def check(robot: Robot, poses: Poses, found: Solutions, accuracy: float = 1e-9) -> None:
    """What every answer owes: true configurations, each once, in (-pi, pi], NaN for the others, counted."""
    real = ~np.isnan(found.q)
    assert np.array_equal(np.all(real, axis=2), np.any(real, axis=2))
    assert np.array_equal(np.sum(real[:, :, 0], axis=1), found.count)
    requested = turned_about_jet(poses, found.azimuth)[real[:, :, 0]]
    assert np.max(miss(flange_poses(robot, found.q[real[:, :, 0]]), requested), initial=0.0) < accuracy
    turns = [joint.kind == "revolute" for joint in robot.joints]
    angles = found.q[:, :, turns]
    assert np.all(np.isnan(angles) | ((angles > -np.pi) & (angles <= np.pi)))
    for one in range(found.q.shape[1]):
        for other in range(one):
            assert np.min(apart(robot, found.q[:, one], found.q[:, other])) > 1e-6


def every_branch_is_true(name: str, count: int) -> None:
    robot = library_robot(name)
    q = random_rows(robot, count, 1)
    poses = flange_poses(robot, q)
    found = solve(robot, poses)
    check(robot, poses, found)
    assert np.max(np.min(apart(robot, found.q, q[:, None]), axis=1)) < AMONG


@pytest.mark.parametrize("name", LIBRARY)
def test_every_branch_brings_the_flange_to_its_pose_and_the_one_we_came_from_is_among_them(name: str) -> None:
    every_branch_is_true(name, 1000)


@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
def test_it_is_so_for_ten_thousand_poses(name: str) -> None:
    every_branch_is_true(name, 10_000)


def none_is_missed(name: str, poses: int, starts: int) -> None:
    robot = library_robot(name)
    for number, pose in enumerate(flange_poses(robot, random_rows(robot, poses, 2))):
        mine = solve(robot, pose).q[0]
        for row in search(robot, pose, starts, number):
            assert np.min(apart(robot, mine, row)) < 1e-5, (number, row)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_a_search_from_many_places_finds_nothing_else(name: str) -> None:
    none_is_missed(name, 10, 300)


def test_the_search_is_worth_its_name() -> None:
    """It finds all eight by itself: a missing one would show."""
    robot = dh_arm("ur5", *UR5)
    pose = flange_poses(robot, np.array([[0.3, -1.2, 1.4, -0.7, -1.1, 0.4]]))[0]
    assert len(search(robot, pose, 300, 0)) == 8


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_ssik_finds_nothing_else(name: str) -> None:
    ssik = pytest.importorskip("ssik")
    robot = library_robot(name)
    frames = np.array([joint.T_parent_joint for joint in robot.joints] + [robot.T_link_flange])
    judge = ssik.Manipulator.from_transforms(frames, np.array([joint.axis for joint in robot.joints]))
    poses = flange_poses(robot, random_rows(robot, 300, 3))
    found = solve(robot, poses)
    for pose, mine, count in zip(poses, found.q, found.count, strict=True):
        others = judge.solve(pose, respect_limits=False, enumerate_windings=False)
        assert len(others) == count
        assert all(np.min(apart(robot, mine, one.q)) < 1e-6 for one in others)


def test_a_ur5_has_eight_configurations_in_reach_and_none_out_of_it() -> None:
    robot = dh_arm("ur5", *UR5)
    pose = flange_poses(robot, np.array([[0.3, -1.2, 1.4, -0.7, -1.1, 0.4]]))
    assert solve(robot, pose).count[0] == 8
    far = np.tile(pose, (4, 1, 1))
    far[0, :3, 3] *= 5.0
    far[1, :3, 3] = [0.0, 0.0, 5.0]
    far[2, :3, 3] = [0.05, 0.0, pose[0, 2, 3]]
    far[3] = np.nan
    assert list(solve(robot, far).count) == [0, 0, 0, 0]


@settings(max_examples=25)
@given(milliradians=st.lists(st.integers(-3000, 3000), min_size=6, max_size=6), yaw=st.floats(-3.0, 3.0))
def test_where_the_robot_stands_changes_nothing(milliradians: list[int], yaw: float) -> None:
    q = np.array([milliradians]) / 1000.0
    robot = dh_arm("ur5", *UR5)
    c, s = np.cos(yaw), np.sin(yaw)
    place = np.array([[c, -s, 0, 0.4], [s, c, 0, -2.0], [0, 0, 1, 0.7], [0, 0, 0, 1]])
    first = robot.joints[0]
    stood = Joint("joint_1", "revolute", place @ first.T_parent_joint, first.axis, -7.0, 7.0, 3.0, 10.0)
    moved = Robot("moved", (stood, *robot.joints[1:]), robot.T_link_flange, robot.bodies)
    pose = flange_poses(robot, q)
    here, there = solve(robot, pose), solve(moved, place @ pose)
    assert here.count[0] == there.count[0]
    real = ~np.isnan(here.q[0, :, 0])
    assert np.max(apart(robot, here.q[0, real], there.q[0, real])) < 1e-5


@pytest.mark.parametrize("name", LIBRARY)
def test_a_branch_keeps_its_place_along_a_path(name: str) -> None:
    """Away from singular poses neighbours have the same branches, each near its like."""
    robot = library_robot(name)
    rows = random_rows(robot, 50, 4)
    begin = rows[np.argmax(singularity(robot, rows)[1])]
    q = begin + np.linspace(-0.1, 0.1, 200)[:, None] * np.cos(np.arange(robot.dof))
    found = solve(robot, flange_poses(robot, q))
    mine = np.argmin(apart(robot, found.q, q[:, None]), axis=1)
    assert len(set(mine)) == 1
    assert np.max(apart(robot, found.q[1:, mine[0]], found.q[:-1, mine[0]])) < 0.02


def test_the_same_poses_give_the_same_bytes() -> None:
    robot = dh_arm("ur5", *UR5)
    poses = flange_poses(robot, random_rows(robot, 50, 5))
    one = solve(robot, poses).q
    assert one.tobytes() == solve(robot, poses).q.tobytes()
    assert one[7].tobytes() == solve(robot, poses[7]).q[0].tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("lengths", [(0.4, 0.35, 0.08), (0.4, 0.4, 0.0), (0.3, 0.5, 0.12)])
def test_the_cairo_arm_obeys_its_corrected_equations(lengths: tuple[float, float, float]) -> None:
    robot = cairo(*lengths)
    poses = flange_poses(robot, random_rows(robot, 200, 6))
    found = solve(robot, poses)
    check(robot, poses, found, 1e-8)
    for pose, mine, count in zip(poses, found.q, found.count, strict=True):
        written = cairo_by_the_paper(pose, *lengths)
        assert len(written) == count
        assert all(np.min(apart(robot, mine, row)) < 1e-6 for row in written)


def cairo_by_the_paper(pose: Poses, a2: float, a3: float, a4: float, d1: float = 0.3, d6: float = 0.1) -> list:
    """The corrected closed form of the Cairo paper: shoulder, sign of joint 5, elbow."""
    n, o, a, p = pose[:3].T
    rows = []
    for shoulder in (0.0, np.pi):
        t1 = np.arctan2(p[1] - d6 * a[1], p[0] - d6 * a[0]) + shoulder
        c1, s1 = np.cos(t1), np.sin(t1)
        for e in (1.0, -1.0):
            c5 = a[1] * c1 - a[0] * s1
            s5 = e * np.sqrt(1.0 - c5 * c5)
            t234 = np.arctan2(e * a[2], -e * (a[0] * c1 + a[1] * s1))
            t6 = np.arctan2(e * (o[0] * s1 - o[1] * c1), e * (n[1] * c1 - n[0] * s1))
            t = c1 * p[0] + s1 * p[1] - a4 * np.cos(t234) + d6 * s5 * np.cos(t234)
            u = d1 - p[2] - a4 * np.sin(t234) + d6 * s5 * np.sin(t234)
            q = np.hypot(t, u)
            share = (q * q + a2 * a2 - a3 * a3) / (2.0 * a2) / q
            for elbow in (1.0, -1.0) if abs(share) <= 1.0 else ():
                t2 = np.arctan2(u, t) + elbow * np.arccos(share)
                t23 = np.arctan2(u - a2 * np.sin(t2), t - a2 * np.cos(t2))
                rows.append(np.array([t1, t2, t23 - t2, t234 - t23, np.arctan2(s5, c5), t6]))
    return rows


def test_axes_that_a_file_has_rounded_are_solved_as_sharply() -> None:
    """1.5708 for half of pi, as many URDF files have it, is an error of 4e-6 rad."""
    robot = dh_arm("rounded", *((round(alpha, 4), a, d) for alpha, a, d in UR5))
    q = random_rows(robot, 300, 7)
    poses = flange_poses(robot, q)
    found = solve(robot, poses)
    check(robot, poses, found, 1e-6)
    assert np.mean(np.min(apart(robot, found.q, q[:, None]), axis=1) < 1e-6) > 0.99


def test_reach_asks_for_the_limits_too() -> None:
    robot = library_robot("kr6-r900")
    q = random_rows(robot, 400, 8)
    poses = flange_poses(robot, q)
    answer = np.any(is_inside(robot, solve(robot, poses).q), axis=1)
    low, high = (np.array([getattr(joint, side) for joint in robot.joints]) for side in ("lowest", "highest"))
    inside = [
        any(
            all(np.any((low <= row + turn) & (row + turn <= high), axis=0))
            for row in rows[~np.isnan(rows[:, 0])]
            for turn in [np.array([[-2.0], [0.0], [2.0]]) * np.pi]
        )
        for rows in solve(robot, poses).q
    ]
    assert list(answer) == inside
    assert 0.2 < np.mean(answer) < 0.9


@pytest.mark.parametrize(
    ("rows", "message"),
    [(UR5 + UR5[:1], "7 turning and 0 straight joints. More than six"), (UR5[:5], "5 turning and 0 straight joints")],
)
def test_robots_without_a_closed_form_are_refused(rows: tuple, message: str) -> None:
    with pytest.raises(CellError, match=message):
        solve(dh_arm("odd", *rows), np.eye(4))


def test_how_a_robot_is_solved_is_told_once() -> None:
    robot = dh_arm("ur5", *UR5)
    assert kinematics_of(robot) is kinematics_of(robot)

"""Whole turns within the limits."""

import itertools

import numpy as np
import pytest
from arms import UR5, apart, dh_arm, library_robot, random_rows

from robotcell.robot.robot import ROUNDING, TURN, Joint, Joints, Robot, is_beyond, is_inside, nearest_turns


def arm(*limits: tuple[float, float]) -> Robot:
    """Turning joints with limits in turns, and a straight one of 0 to 1 m before them."""
    z = np.array([0.0, 0.0, 1.0])
    slide = Joint("slide", "prismatic", np.eye(4), z, 0.0, 1.0, 1.0, 1.0)
    turning = [
        Joint(f"j{n}", "revolute", np.eye(4), z, low * 2 * np.pi, high * 2 * np.pi, 1.0, 1.0)
        for n, (low, high) in enumerate(limits)
    ]
    return Robot("arm", (slide, *turning), np.eye(4), ((),) * (len(limits) + 2))


def all_turns(robot: Robot, q: Joints) -> Joints:
    """Every row (m, dof) within the limits that differs from a row (dof,) by whole turns; in ascending order."""
    numbers = np.arange(-5, 6)
    choices: list[list[float]] = []
    for joint, value in zip(robot.joints, q.tolist(), strict=True):
        turned = value + TURN * numbers * (joint.kind == "revolute" and np.isfinite(joint.lowest))
        inside = (turned >= joint.lowest - ROUNDING) & (turned <= joint.highest + ROUNDING)
        choices.append(sorted(set(turned[inside].tolist())))
    return np.array(list(itertools.product(*choices))).reshape(-1, robot.dof)


def test_a_joint_of_two_turns_has_two_ways_and_one_of_a_half_has_one_or_none() -> None:
    robot = arm((-1.0, 1.0), (-0.25, 0.25))
    rows = all_turns(robot, np.array([0.5, 1.0, 0.1]))
    np.testing.assert_allclose(rows, [[0.5, 1.0 - 2 * np.pi, 0.1], [0.5, 1.0, 0.1]])
    assert all_turns(robot, np.array([0.5, 1.0, 2.0])).shape == (0, 3)
    assert all_turns(robot, np.array([1.5, 1.0, 0.1])).shape == (0, 3)


def test_at_the_ends_of_two_turns_there_are_three_ways() -> None:
    rows = all_turns(arm((-1.0, 1.0)), np.array([0.0, 0.0]))
    np.testing.assert_allclose(rows[:, 1], [-2 * np.pi, 0.0, 2 * np.pi])


def test_a_joint_that_turns_without_end_keeps_its_angle_or_follows() -> None:
    robot = arm((-np.inf, np.inf))
    assert all_turns(robot, np.array([0.5, 1.0])).tolist() == [[0.5, 1.0]]
    np.testing.assert_allclose(
        nearest_turns(robot, np.array([0.5, 1.0]), np.array([0.5, 40.0])), [0.5, 1.0 + 12 * np.pi]
    )


def test_a_ur5_has_sixty_four_ways_but_where_its_elbow_is_limited() -> None:
    assert len(all_turns(dh_arm("ur5", *UR5), np.full(6, 1.0))) == 64
    assert len(all_turns(library_robot("ur5"), np.full(6, 1.0))) == 32


@pytest.mark.parametrize("name", ["ur5", "kr6-r900"])
def test_the_nearest_is_one_of_all_and_none_is_nearer(name: str) -> None:
    robot = library_robot(name)
    q, near = random_rows(robot, 100, 1), 2.0 * random_rows(robot, 100, 2)
    for row, goal, chosen in zip(q, near, nearest_turns(robot, q, near), strict=True):
        ways = all_turns(robot, row)
        assert bool(is_inside(robot, row)) == (len(ways) > 0)
        if len(ways) == 0:
            assert np.all(np.isnan(chosen))
            continue
        assert np.min(np.max(np.abs(ways - chosen), axis=1)) < 1e-9
        assert np.linalg.norm(chosen - goal) <= np.min(np.linalg.norm(ways - goal, axis=1)) + 1e-9
        assert apart(robot, chosen, row) < 1e-9


def test_rows_of_nothing_stay_nothing() -> None:
    robot = library_robot("ur5")
    nothing = np.full((2, 8, 6), np.nan)
    assert not np.any(is_inside(robot, nothing))
    assert np.all(np.isnan(nearest_turns(robot, nothing, np.zeros(6))))


def test_a_row_is_beyond_where_one_joint_is_beyond_its_limit_whatever_whole_turns_would_do() -> None:
    robot = arm((-0.25, 0.25))
    rows = np.array([[0.0, 0.25], [1.0, -0.25], [0.5, 0.26], [0.5, -0.26], [0.5, 1.0], [1.001, 0.0], [-0.001, 0.0]])
    rows[:, 1] *= TURN
    assert is_beyond(robot, rows).tolist() == [False, False, True, True, True, True, True]

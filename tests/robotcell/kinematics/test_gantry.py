"""Five axes bring the orifice and the jet where they belong; the azimuth follows and is reported."""

from dataclasses import replace

import numpy as np
import pytest
from arms import apart, library_robot, random_rows
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.errors import CellError
from robotcell.kinematics.inverse import solve
from robotcell.robot.robot import Poses, Robot, flange_poses, is_inside


def about(axis: str, angle: float) -> Poses:
    """Turn about x, y or z."""
    one, two = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    pose = np.eye(4)
    pose[one, one] = pose[two, two] = np.cos(angle)
    pose[two, one] = np.sin(angle)
    pose[one, two] = -pose[two, one]
    return pose


def at(x: float, y: float, z: float) -> Poses:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


LANCE = at(0.02, -0.01, 0.12) @ about("x", 0.3) @ about("z", 0.5)


@pytest.fixture
def gantry() -> Robot:
    return library_robot("gantry")


def down(robot: Robot) -> Poses:
    """A pose of the flange with the jet along the first turning axis."""
    q = np.zeros((1, 5))
    pose = flange_poses(robot, q)
    axis = robot_axis(robot)
    for angle in np.linspace(-np.pi, np.pi, 5):
        q[0, 4] = angle
        pose = flange_poses(robot, q)
        if np.linalg.norm(np.cross(pose[0, :3, 2], axis)) < 1e-9:
            return pose
    raise AssertionError("this gantry cannot spray straight down")


def robot_axis(robot: Robot) -> np.ndarray:
    step = np.zeros((2, 5))
    step[1, 3] = 1e-6
    turn = flange_poses(robot, step)
    change = (turn[1, :3, :3] @ turn[0, :3, :3].T - np.eye(3)) / 1e-6
    return np.array([change[2, 1], change[0, 2], change[1, 0]])


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), tilt=st.floats(-0.6, 0.6), turn=st.floats(-3.0, 3.0))
def test_with_any_tool_the_orifice_and_the_jet_are_as_requested(seed: int, tilt: float, turn: float) -> None:
    robot = library_robot("gantry")
    tool = at(0.02, -0.01, 0.12) @ about("x", tilt) @ about("z", turn)
    q = random_rows(robot, 20, seed)
    requested = flange_poses(robot, q)
    found = solve(robot, requested, T_flange_tcp=tool)
    assert np.max(np.min(apart(robot, found.q, q[:, None]), axis=1)) < 1e-6
    tips = (requested @ tool)[:, None] @ np.array([[about("z", one) for one in row] for row in found.azimuth])
    reached = flange_poses(robot, np.nan_to_num(found.q).reshape(-1, 5)).reshape(20, 2, 4, 4) @ tool
    real = ~np.isnan(found.q[:, :, 0])
    assert np.max(np.abs(reached - tips)[real]) < 1e-9


def test_another_azimuth_asks_for_the_same_joints(gantry: Robot) -> None:
    """They cannot turn the nozzle about a tilted jet: the difference is reported instead."""
    requested = flange_poses(gantry, np.array([[0.1, 0.05, -0.1, 0.4, 0.5]]))
    straight = solve(gantry, requested, T_flange_tcp=LANCE)
    turned = solve(gantry, requested @ LANCE @ about("z", 0.8) @ np.linalg.inv(LANCE), T_flange_tcp=LANCE)
    np.testing.assert_allclose(turned.q, straight.q, atol=1e-9)
    away = turned.azimuth - straight.azimuth + 0.8
    np.testing.assert_allclose(np.sin(away), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.cos(away), 1.0, atol=1e-9)


def test_straight_down_the_azimuth_can_be_had_and_its_opposite_is_offered_too(gantry: Robot) -> None:
    requested = down(gantry) @ about("z", 0.7)
    found = solve(gantry, requested)
    assert found.count[0] == 2
    assert found.azimuth[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert abs(found.azimuth[0, 1]) == pytest.approx(np.pi, abs=1e-9)


@pytest.mark.parametrize("tilt", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_hardly_tilted_jet_loses_no_digits(gantry: Robot, tilt: float) -> None:
    requested = down(gantry) @ about("x", tilt)
    found = solve(gantry, requested)
    assert found.count[0] == 2
    reached = flange_poses(gantry, found.q[0])
    np.testing.assert_allclose(reached[:, :3, 2], requested[[0, 0], :3, 2], atol=2e-9)
    np.testing.assert_allclose(reached[:, :3, 3], requested[[0, 0], :3, 3], atol=1e-12)


def test_a_pose_beyond_the_travel_is_solved_and_outside_the_limits(gantry: Robot) -> None:
    requested = np.concatenate([down(gantry), at(5.0, 0.0, 0.0) @ down(gantry)])
    assert list(solve(gantry, requested).count) == [2, 2]
    assert not is_inside(gantry, solve(gantry, requested).q[1]).any()


def test_a_leaning_tool_cannot_spray_straight_down_without_tilting_back(gantry: Robot) -> None:
    """With the jet leaned about the nozzle's own way of tilting only; sideways there is no such configuration."""
    q = np.array([[0.0, 0.0, 0.0, 0.3, 0.0]])
    swing = robot_axis(gantry)
    tilted_tools = [np.array(about(axis, 0.4)) for axis in "xy"]
    counts = []
    for tool in tilted_tools:
        requested = down(gantry) @ np.linalg.inv(tool)
        found = solve(gantry, requested, T_flange_tcp=tool)
        counts.append(int(found.count[0]))
        for row in found.q[0, : found.count[0]]:
            jet = (flange_poses(gantry, row[None]) @ tool)[0, :3, 2]
            assert np.linalg.norm(np.cross(jet, swing)) < 1e-7
    assert sorted(counts) == [0, 2]
    assert solve(gantry, flange_poses(gantry, q)).count[0] == 2


def test_a_jet_along_the_tilting_axis_is_refused(gantry: Robot) -> None:
    step = flange_poses(gantry, np.array([[0.0] * 5, [0.0] * 4 + [1e-6]]))
    change = (step[0, :3, :3].T @ step[1, :3, :3] - np.eye(3)) / 1e-6
    axis = np.array([change[2, 1], change[0, 2], change[1, 0]])
    tool = np.eye(4)
    tool[:3, 2] = axis
    tool[:3, 0] = np.roll(axis, 1)
    tool[:3, 1] = np.cross(axis, tool[:3, 0])
    with pytest.raises(CellError, match="which cannot tilt it"):
        solve(gantry, np.eye(4), T_flange_tcp=tool)


def test_axes_that_do_not_span_space_are_refused(gantry: Robot) -> None:
    flat = replace(gantry, joints=(gantry.joints[0], *gantry.joints[:1], *gantry.joints[2:]))
    with pytest.raises(CellError, match="do not span space"):
        solve(flat, np.eye(4))

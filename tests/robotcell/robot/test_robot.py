"""Manipulability and inverse condition, against the formulas of the papers."""

import numpy as np
import pytest
from arms import UR5, cairo, dh_arm, library_robot, random_rows
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from robotcell.kinematics.inverse import solve
from robotcell.robot.robot import CHARACTERISTIC_LENGTH, flange_manipulability, flange_poses, singularity

A2, A3, D5 = -0.425, -0.39225, 0.09465


def test_a_ur5_obeys_the_formula_of_the_maribor_paper() -> None:
    robot = dh_arm("ur5", *UR5)
    q = random_rows(robot, 500, 1)
    t2, t23, t234 = q[:, 1], q[:, 1] + q[:, 2], q[:, 1] + q[:, 2] + q[:, 3]
    reach = A2 * np.cos(t2) + A3 * np.cos(t23) + D5 * np.sin(t234)
    written = np.abs(A2 * A3 * np.sin(q[:, 2]) * np.sin(q[:, 4]) * reach)
    np.testing.assert_allclose(singularity(robot, q)[0], written, atol=1e-12)


def test_its_greatest_value_is_that_of_the_paper() -> None:
    robot = dh_arm("ur5", *UR5)
    rows = random_rows(robot, 2000, 6)
    start = rows[np.argmax(singularity(robot, rows)[0])]
    best = minimize(lambda q: -float(singularity(robot, q[None])[0][0]), start, tol=1e-10)
    assert -best.fun == pytest.approx(0.119880, abs=5e-7)


def test_its_eight_configurations_have_four_values() -> None:
    robot = dh_arm("ur5", *UR5)
    found = solve(robot, flange_poses(robot, np.array([[0.3, -1.2, 1.4, -0.7, -1.1, 0.4]])))
    w = np.sort(singularity(robot, found.q[0])[0])
    assert len(w) == 8
    np.testing.assert_allclose(w[::2], w[1::2], rtol=1e-9)
    assert np.all(np.diff(w[::2]) > 1e-4)


def test_the_cairo_arm_obeys_its_determinant() -> None:
    a2, a3, a4 = 0.4, 0.35, 0.08
    robot = cairo(a2, a3, a4)
    q = random_rows(robot, 500, 2)
    t2, t23, t234 = q[:, 1], q[:, 1] + q[:, 2], q[:, 1] + q[:, 2] + q[:, 3]
    reach = a2 * np.cos(t2) + a3 * np.cos(t23) + a4 * np.cos(t234)
    written = np.abs(a2 * a3 * np.sin(q[:, 2]) * np.sin(q[:, 4]) * reach)
    np.testing.assert_allclose(singularity(robot, q)[0], written, atol=1e-12)


@settings(max_examples=30)
@given(seed=st.integers(0, 1000), x=st.floats(-0.3, 0.3), z=st.floats(-0.3, 0.3))
def test_w_does_not_ask_where_the_tool_is_nor_how_the_robot_is_turned(seed: int, x: float, z: float) -> None:
    robot = library_robot("ur5e")
    q = random_rows(robot, 20, seed)
    tool = np.eye(4)
    tool[:3, 3] = x, 0.1, z
    np.testing.assert_allclose(singularity(robot, q, tool)[0], singularity(robot, q)[0], atol=1e-12)
    turned = q + np.array([0.7, 0, 0, 0, 0, 0])
    for one, other in zip(singularity(robot, q, tool), singularity(robot, turned, tool), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


@pytest.mark.parametrize("joint", [2, 4])
def test_both_vanish_where_a_ur5_is_singular(joint: int) -> None:
    robot = dh_arm("ur5", *UR5)
    q = random_rows(robot, 20, 3)
    q[:, joint] = 0.0
    w, inverse = singularity(robot, q)
    assert np.max(w) < 1e-15
    assert np.max(inverse) < 1e-9
    q[:, joint] = 0.5
    assert np.max(singularity(robot, q)[1]) > 0.01


def test_the_inverse_condition_is_between_nothing_and_one_and_knows_its_length() -> None:
    robot = dh_arm("ur5", *UR5)
    q = random_rows(robot, 200, 4)
    inverse = singularity(robot, q)[1]
    assert np.all((inverse >= 0.0) & (inverse <= 1.0))
    np.testing.assert_array_equal(inverse, singularity(robot, q, length=CHARACTERISTIC_LENGTH)[1])
    assert np.max(np.abs(inverse - singularity(robot, q, length=1.0)[1])) > 0.01


def test_a_gantry_is_nowhere_singular() -> None:
    robot = library_robot("gantry")
    rows = random_rows(robot, 200, 5)
    w, inverse = singularity(robot, rows)
    np.testing.assert_array_equal(flange_manipulability(robot, rows), w)
    np.testing.assert_allclose(w, w[0])
    assert np.min(inverse) > 0.1

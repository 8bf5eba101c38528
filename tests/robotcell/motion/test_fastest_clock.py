import logging
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from toppra.algorithm import TOPPRA
from toppra.constraint.linear_constraint import LinearConstraint

from robotcell.motion.retime import fastest_clock

logging.getLogger("toppra").addHandler(logging.NullHandler())


def toppra_clock(length: np.ndarray, of_u: np.ndarray, of_x: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """What toppra finds, between two stages in which the rate is free to change."""
    idle = np.zeros((1, 2 * of_u.shape[1]))
    a = np.concatenate((idle, np.hstack((of_u, -of_u)), idle, idle))
    b = np.concatenate((idle, np.hstack((of_x, -of_x)), idle, idle))
    most = np.concatenate(([0.0], highest, [0.0]))
    grid = np.concatenate(([0.0, 1.0], 1.0 + np.cumsum(length), [2.0 + length.sum()]))

    class Rows(LinearConstraint):
        def compute_constraint_params(self, path: Any, gridpoints: Any, *_: Any, **__: Any) -> tuple[Any, ...]:
            bounds = np.stack((np.zeros_like(most), most), axis=1)
            return a, b, np.zeros_like(a), np.eye(a.shape[1]), np.ones(a.shape[1]), None, bounds

    limits = Rows()
    limits.identical, limits.dof = True, 1
    line = SimpleNamespace(dof=1, path_interval=grid[[0, -1]])
    solver = TOPPRA([limits], line, gridpoints=grid, solver_wrapper="seidel", parametrizer="ParametrizeConstAccel")
    solver.compute_parameterization(0.0, 0.0)
    return solver.problem_data.sd_vec[1:-1] ** 2


def a_run(seed: int) -> tuple[np.ndarray, ...]:
    """Rows of joints that go, turn back and stand, over stages of a millisecond to a tenth of a second."""
    rng = np.random.default_rng(seed)
    stages, joints = int(rng.integers(1, 80)), int(rng.integers(1, 7))
    length = 10.0 ** rng.uniform(-3.0, -1.0, stages)
    of_u = rng.normal(0.0, 1.0, (stages, 2 * joints)) * (rng.random((stages, 2 * joints)) < 0.8)
    of_x = rng.normal(0.0, 10.0 ** rng.uniform(-2.0, 1.5), (stages, 2 * joints))
    highest = np.where(rng.random(stages + 1) < 0.2, rng.random(stages + 1), 1.0)
    highest[[0, -1]] = np.where(rng.random(2) < 0.3, 0.0, highest[[0, -1]])
    return length, of_u, of_x, highest


@pytest.mark.parametrize("seed", range(40))
def test_it_is_the_clock_that_toppra_finds(seed: int) -> None:
    run = a_run(seed)
    np.testing.assert_allclose(fastest_clock(*run), toppra_clock(*run), atol=1e-9, rtol=1e-9)


def test_a_run_without_limits_of_its_own_is_as_fast_as_its_samples_allow() -> None:
    nothing = np.zeros((3, 2))
    free = fastest_clock(np.full(3, 0.1), nothing, nothing, np.array([1.0, 0.25, 1.0, 0.0]))
    np.testing.assert_allclose(free, [1.0, 0.25, 1.0, 0.0], rtol=1e-4, atol=1e-7)


def test_the_rows_and_the_greatest_rates_hold() -> None:
    for seed in range(40, 80):
        length, of_u, of_x, highest = a_run(seed)
        squared = fastest_clock(length, of_u, of_x, highest)
        change = np.diff(squared) / (2.0 * length)
        assert (np.abs(of_u * change[:, None] + of_x * squared[:-1, None]) <= 1.0 + 1e-4).all(), seed
        assert (squared >= 0.0).all()
        assert (squared <= highest).all()

"""The interior-point method finds the optimum of other solvers, with multipliers that prove it."""

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.sparse import csr_array

from geometry.coverage.dwell import minimise


def boxed(dense, limits):
    """Rows with 0 <= x <= 1 added."""
    count = dense.shape[1]
    matrix = np.vstack([dense, np.eye(count), -np.eye(count)])
    return csr_array(matrix), np.concatenate([limits, np.ones(count), np.zeros(count)])


@pytest.mark.parametrize("seed", range(5))
def test_the_least_and_its_proof_are_those_of_the_simplex(seed) -> None:
    rng = np.random.default_rng(seed)
    costs, dense = rng.normal(size=8), rng.uniform(-0.3, 1.0, (60, 8))
    matrix, limits = boxed(dense, np.full(60, 1.5))
    found = minimise(costs, matrix, limits, np.full(8, 0.5), 1e-9)
    least = linprog(costs, A_ub=dense, b_ub=np.full(60, 1.5), bounds=(0, 1), method="highs").fun
    assert costs @ found.values == pytest.approx(least, abs=1e-8)
    assert -limits @ found.multipliers == pytest.approx(least, abs=1e-7)
    assert (matrix @ found.values <= limits + 1e-9).all()


def test_of_many_optima_it_takes_one_inside() -> None:
    """x + y >= 1 binds; a vertex would have one of them at 0."""
    matrix, limits = boxed(np.array([[-1.0, -1.0]]), np.array([-1.0]))
    found = minimise(np.ones(2), matrix, limits, np.array([0.9, 0.3]), 1e-9)
    assert found.values.sum() == pytest.approx(1.0, abs=1e-8)
    assert found.values.min() > 0.05


def test_rows_that_contradict_each_other_are_refused() -> None:
    matrix, limits = boxed(np.array([[1.0, 1.0], [-1.0, -1.0]]), np.array([0.5, -1.0]))
    with pytest.raises(ValueError, match="nothing keeps"):
        minimise(np.ones(2), matrix, limits, np.full(2, 0.5), 1e-9)

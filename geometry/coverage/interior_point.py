"""Interior-point method for linear programs with many sparse rows and few unknowns.

Mehrotra's predictor-corrector method (SIAM Journal on Optimization 2, 1992). All rows take part in normal equations
G' D G that are no larger than the unknowns. It does not go on to a vertex: among optima it ends inside of what they
span, where values swing less beside the rows than in a vertex.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array

from geometry.arrays import Scalars
from geometry.compiled import compiled

_ITERATIONS = 100
_STEP = 0.995
"""Share taken of the way to the nearest bound."""
_LEAST_SLACK = 1e-2
"""Of the rows at the beginning."""
_RESIDUAL = 1e-6
"""Of the costs, that rounding may leave: where rows repeat each other the normal equations are all but singular."""
_ENDLESS = 1e12
"""Multipliers that grow beyond it prove a contradiction of the rows."""
_REGULAR = 1e-13
"""Added to the scaled normal equations, whose diagonal is 1: rows that all but fix an unknown make them singular."""


@dataclass(frozen=True, slots=True, eq=False)
class Optimum:
    """Primal and dual solution."""

    values: Scalars
    """(n,)"""
    multipliers: Scalars
    """(m,) at least 0, of the rows: ``costs + matrix.T @ multipliers`` is all but 0."""
    iterations: int


def minimise(costs: Scalars, matrix: csr_array, limits: Scalars, start: Scalars, tolerance: float) -> Optimum:
    """Find the x with ``matrix @ x <= limits`` whose ``costs @ x`` is least.

    Args:
        costs: (n,)
        matrix: (m, n) rows and unknowns of about the same size; the rows bound every unknown.
        limits: (m,)
        start: (n,) where to begin; it may break rows.
        tolerance: Of the duality gap and of the residuals of rows, and of costs down to 1e-6.

    Raises:
        ValueError: no x keeps all rows.
    """
    matrix = csr_array(matrix.sorted_indices())
    across = csr_array(matrix.T)
    x = start
    slack = np.maximum(limits - matrix @ x, _LEAST_SLACK)
    duals = max(abs(float(costs @ x)), _LEAST_SLACK) / len(limits) / slack
    for number in range(_ITERATIONS):
        rows, columns = limits - matrix @ x - slack, -costs - across @ duals
        gap = float(slack @ duals)
        if max(gap, float(np.abs(rows).max())) < tolerance and float(np.abs(columns).max()) < max(tolerance, _RESIDUAL):
            return Optimum(x, duals, number)
        if float(duals.max()) > _ENDLESS:
            break
        normal = np.zeros((len(x), len(x)))
        _add_squares(matrix.indptr, matrix.indices, matrix.data, duals / slack, normal)
        scale = 1.0 / np.sqrt(normal.diagonal())
        normal *= scale[:, None] * scale
        normal[np.diag_indices_from(normal)] += _REGULAR
        factor = cho_factor(normal, lower=True, overwrite_a=True, check_finite=False)
        state = _State(matrix, across, slack, duals, rows, columns, scale, factor)
        _, d_slack, d_duals = state.direction(-slack * duals)
        ahead = (slack + _reach(slack, d_slack) * d_slack) @ (duals + _reach(duals, d_duals) * d_duals)
        centre = (float(ahead) / gap) ** 3 * gap / len(limits)
        change, d_slack, d_duals = state.direction(centre - slack * duals - d_slack * d_duals)
        forward, dual = (min(1.0, _STEP * _reach(*each)) for each in ((slack, d_slack), (duals, d_duals)))
        x, slack, duals = x + forward * change, slack + forward * d_slack, duals + dual * d_duals
    raise ValueError("nothing keeps to the bounds: the interior-point method does not converge")


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """The linearised conditions of an optimum at one iterate."""

    matrix: csr_array
    across: csr_array
    slack: Scalars
    duals: Scalars
    rows: Scalars
    columns: Scalars
    scale: Scalars
    factor: tuple[Scalars, bool]

    def direction(self, products: Scalars) -> tuple[Scalars, Scalars, Scalars]:
        """Changes of x, slacks and duals that bring residuals to 0 and slack * dual to change by ``products``."""
        right = self.columns - self.across @ ((products - self.duals * self.rows) / self.slack)
        change = self.scale * cho_solve(self.factor, self.scale * right, check_finite=False)
        d_slack = self.rows - self.matrix @ change
        return change, d_slack, (products - self.duals * d_slack) / self.slack


@compiled
def _add_squares(
    starts: NDArray[np.int32],
    columns: NDArray[np.int32],
    values: NDArray[np.float64],
    weights: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Add the lower triangle of G' D G to (n, n) sums, of m sorted sparse rows G with (m,) weights D."""
    for row in range(len(weights)):
        for i in range(starts[row], starts[row + 1]):
            value, line = weights[row] * values[i], sums[columns[i]]
            for j in range(starts[row], i + 1):
                line[columns[j]] += value * values[j]


def _reach(values: Scalars, changes: Scalars) -> float:
    """Share of a change, at most all, after which the first of some positive values is 0."""
    falls = changes < 0.0
    return min(1.0, float(np.min(-values[falls] / changes[falls], initial=np.inf)))

"""Linear programs for how long a tool is to stay on each segment of its path, so that what it lays is enough or even.

A matrix holds what each segment lays on each cell in a second; A t is what lies there after times t. ``least_time``
finds the least sum of times with A t at least what is required; ``even_film`` the times whose greatest deviation
|A t - q| / q is least (minimax). Both are convex, so that a feasible dual solution proves how far from the optimum a
solution can be: the duality gap, over all cells, is part of the answer. Jiangsu 2010, eq. (7), weighs deviations of
passes from their own mean, and is blind to the thickness itself.

Of least time few cells bind, and rows are generated: a program over some of the cells is solved, the cells that it
violates most are added, until none is violated. An even film is bound by cells everywhere: its program has them all.

Programs of an even film have many sparse rows and few unknowns: an interior-point method, Mehrotra's
predictor-corrector (SIAM Journal on Optimization 2, 1992). All rows take part in normal equations
G' D G that are no larger than the unknowns. It does not go on to a vertex: among optima it ends inside of what they
span, where values swing less beside the rows than in a vertex.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import bmat, coo_array, csr_array, diags_array, eye_array, vstack

from geometry.arrays import Indices, Scalars
from geometry.compiled import compiled

_FIRST = 800
"""Cells of the first program."""
_ADDED = 600
"""Cells that a round adds at most."""
_ROUNDS = 40
_PER_UNKNOWN = 4
TOLERANCE = 3e-5
"""Of a violation, relative to the film."""
_GAP = 1e-7
"""Duality gap at which the search for an even film ends, in shares of the film."""
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
class Unknowns:
    """What is to be found: n times of segments, or n paces (seconds per length) at knots, linear between them."""

    seconds: Scalars
    """(n,) how much one unit of each adds to the time: 1 for times, lengths for paces."""
    least: Scalars
    """(n,)"""
    most: Scalars
    """(n,)"""
    pairs: Indices
    """(c, 2) unknowns i, j with ``slope`` x_j - x_i <= ``change``; of paces that bounds the acceleration."""
    slope: Scalars
    """(c,) at least 0."""
    change: Scalars
    """(c,)"""


def keep_acceleration(
    unknowns: Unknowns, paces: Scalars, neighbours: Indices, ways: Scalars, acceleration: float
) -> Unknowns:
    """Bound the paces of neighbouring knots so that speeds between them keep to an acceleration.

    Of two paces p and q a way d apart p >= g(q) = (1/q² + 2 a d)^(-1/2) is required, and the same of q. g is concave:
    its tangent at a pace near by lies above it, so that what the tangents allow keeps to the acceleration. A solution
    stays allowed if the tangents are laid at its own paces, and solving again can only be better.

    Args:
        unknowns: Whose pairs are replaced.
        paces: (n,) at which the tangents are laid, s/mm.
        neighbours: (c, 2) knots.
        ways: (c,) between them, mm.
        acceleration: mm/s².
    """
    pairs, both = np.concatenate([neighbours, neighbours[:, ::-1]]), np.concatenate([ways, ways])
    at = paces[pairs[:, 1]]
    squares = at**-2.0 + 2.0 * acceleration * both
    slope = at**-3.0 * squares**-1.5
    return replace(unknowns, pairs=pairs, slope=slope, change=slope * at - squares**-0.5)


@dataclass(frozen=True, slots=True, eq=False)
class DwellTimes:
    """An optimum, and the proof of it."""

    values: Scalars
    """(n,) of the unknowns."""
    value: float
    """Of the goal over all cells: seconds, or the greatest relative deviation."""
    bound: float
    """What no times can beat, by a dual solution."""
    rounds: int
    cells: Indices
    """Of the last program."""
    short: Indices
    """Cells that cannot get what they require within the bounds; they get all they can."""

    @property
    def rows(self) -> int:
        """Number of cells of the last program."""
        return len(self.cells)

    @property
    def gap(self) -> float:
        """Relative duality gap: how far the value may be above the optimum."""
        return max(0.0, self.value - self.bound) / max(abs(self.value), 1e-12)


def least_time(rates: csr_array, required: Scalars, unknowns: Unknowns, first: Indices | None = None) -> DwellTimes:
    """Find the least time with ``rates @ x >= required``.

    Args:
        rates: (m, n) what one unit of each unknown lays on each cell.
        required: (m,) at least 0. A cell that cannot get it is to get what it can.
        unknowns: Their bounds.
        first: Cells of the first program, such as those of the last one of a similar problem.

    Raises:
        ValueError: none within the bounds keep to the changes.
    """
    reachable = rates @ unknowns.most
    short = np.flatnonzero(reachable < required * (1.0 - TOLERANCE))
    required = np.minimum(required, reachable * (1.0 - TOLERANCE))
    useful = np.flatnonzero(required > 0.0)
    relative = _scaled(csr_array(rates[useful]), 1.0 / required[useful])

    begin = None if first is None else np.flatnonzero(np.isin(useful, first))
    found, rounds, rows = _generate(relative, unknowns, begin)
    return DwellTimes(found.values, float(unknowns.seconds @ found.values), found.bound, rounds, useful[rows], short)


def even_film(
    rates: csr_array,
    film: Scalars,
    unknowns: Unknowns,
    there: Scalars | None = None,
) -> DwellTimes:
    """Find the unknowns x whose greatest relative deviation |there + rates @ x - film| / film is least.

    Args:
        rates: (m, n) what one unit of each unknown lays on each cell.
        film: (m,) above 0.
        unknowns: Their bounds.
        there: (m,) what lies on the cells already; left out, nothing.

    Raises:
        ValueError: none within the bounds keep to the changes.
    """
    count, cells = len(unknowns.seconds), len(film)
    # Unknowns in shares of their largest values: times, paces and lengths are then of one size.
    units = np.maximum(np.maximum(np.abs(unknowns.least), np.abs(unknowns.most)), 1e-12)
    unit = diags_array(units)
    relative = csr_array(_scaled(rates, 1.0 / film) @ unit)
    changes = csr_array(_changes(unknowns) @ unit)
    largest = np.maximum(np.asarray(abs(changes).max(axis=1).todense(), dtype=np.float64).ravel(), 1e-12)
    missing = np.ones(cells) if there is None else 1.0 - there / film
    low, high = unknowns.least / units, unknowns.most / units
    one, least = eye_array(count), csr_array(-np.ones((cells, 1)))
    bounded = vstack([_scaled(changes, 1.0 / largest), one, -one])
    matrix = csr_array(bmat([[relative, least], [-relative, least], [bounded, None]]))
    limits = np.concatenate([missing, -missing, unknowns.change / largest, high, -low])
    begin = np.clip(np.ones(count), low, high)
    worst = float(np.abs(relative @ begin - missing).max())
    found = minimise(np.append(np.zeros(count), 1.0), matrix, limits, np.append(begin, 1.1 * worst), _GAP)
    values = np.clip(found.values[:count], low, high)
    # What the multipliers of the cells leave of the costs goes to the better end of each range.
    y = found.multipliers[: 2 * cells + len(largest)]
    y = y / max(1.0, float(y[: 2 * cells].sum()))
    reduced = (matrix[: len(y)].T @ y)[:count]
    bound = float(-y @ limits[: len(y)] + np.minimum(reduced * low, reduced * high).sum())
    value = float(np.abs(relative @ values - missing).max())
    return DwellTimes(values * units, value, max(bound, 0.0), 1, np.arange(cells), np.empty(0, dtype=np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    values: Scalars
    bound: float
    """Value of the dual solution."""


def _generate(relative: csr_array, unknowns: Unknowns, first: Indices | None = None) -> tuple[_Solved, int, Indices]:
    """Solve ``relative @ x >= 1`` over some cells, add those that are violated most, until none is."""
    cells = len(relative.indptr) - 1
    strongest = _strongest(relative)
    rows = np.unique(np.linspace(0, cells - 1, min(cells, _FIRST)).astype(np.int64)) if first is None else first
    number = 0
    while True:
        number += 1
        found = _solve(csr_array(relative[rows]), unknowns)
        over = 1.0 - np.asarray(relative @ found.values, dtype=np.float64)
        over[rows] = -np.inf
        wrong = np.flatnonzero(over > TOLERANCE)
        if not wrong.size or number == _ROUNDS:
            return found, number, rows
        # The worst of each segment's surroundings, so that one bad corner does not fill the program.
        order = wrong[np.lexsort((wrong, -over[wrong]))]
        _, first = np.unique(strongest[order], return_index=True)
        each = [first]
        rest = np.setdiff1d(np.arange(len(order)), first)
        for _ in range(_PER_UNKNOWN - 1):
            _, more = np.unique(strongest[order[rest]], return_index=True)
            each.append(rest[more])
            rest = np.setdiff1d(rest, rest[more])
        chosen = order[np.sort(np.concatenate(each))[:_ADDED]]
        rows = np.union1d(rows, chosen)


def _strongest(rates: csr_array) -> Indices:
    """(m,) segment that lays most on each cell."""
    counts = np.diff(np.asarray(rates.indptr, dtype=np.int64))
    found = np.zeros(len(counts), dtype=np.int64)
    full = np.flatnonzero(counts)
    row = np.repeat(np.arange(len(counts)), counts)
    order = np.lexsort((rates.indices, -np.asarray(rates.data, dtype=np.float64), row))
    found[full] = rates.indices[order[rates.indptr[full]]]
    return found


def _solve(relative: csr_array, unknowns: Unknowns) -> _Solved:
    """Find the least time with ``relative @ x >= 1``."""
    from scipy.optimize import linprog  # late: a plan over a board does without it

    matrix = csr_array(vstack([-relative, _changes(unknowns)]))
    limits = np.concatenate([np.full(relative.shape[0], -1.0), unknowns.change])
    bounds = np.column_stack([unknowns.least, unknowns.most])
    # The interior point method is many times as fast here as the simplex; its crossover ends in a vertex as exact.
    arguments: dict[str, Any] = {"A_ub": matrix, "b_ub": limits, "bounds": bounds}
    done = linprog(unknowns.seconds, **arguments, method="highs-ipm")
    if done.status not in (0, 2):
        done = linprog(unknowns.seconds, **arguments, method="highs")
    if done.status != 0:
        raise ValueError(f"nothing keeps to the bounds: {done.message}")
    # Any multipliers y >= 0 of the rows bound the optimum: the rest of the costs goes to the better end of each range.
    y = np.maximum(-np.asarray(done.ineqlin.marginals, dtype=np.float64), 0.0)
    reduced = unknowns.seconds + matrix.T @ y
    bound = float(-y @ limits + reduced @ np.where(reduced > 0.0, unknowns.least, unknowns.most))
    return _Solved(np.asarray(done.x, dtype=np.float64), bound)


def _changes(unknowns: Unknowns) -> csr_array:
    """(c, n) differences of pairs."""
    count = len(unknowns.pairs)
    rows, places = np.repeat(np.arange(count), 2), unknowns.pairs.reshape(-1)
    values = np.column_stack([np.full(count, -1.0), unknowns.slope]).reshape(-1)
    return csr_array(coo_array((values, (rows, places)), shape=(count, len(unknowns.seconds))))


def _scaled(matrix: csr_array, factors: NDArray[np.float64]) -> csr_array:
    """Rows times factors."""
    counts = np.diff(np.asarray(matrix.indptr, dtype=np.int64))
    return csr_array((matrix.data * np.repeat(factors, counts), matrix.indices, matrix.indptr), shape=matrix.shape)


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

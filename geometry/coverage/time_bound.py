"""The linear program of ``dwell`` by a first-order method: a bound to the least time, and times of few groups.

Primal-dual hybrid gradient with diagonal steps (Pock and Chambolle, Diagonal preconditioning for first order
primal-dual algorithms, 2011), over-relaxed, and restarted at the mean of its iterates (Applegate and others, Practical
large-scale linear programming using primal-dual hybrid gradient, 2021). Any multipliers bound the program, so that the
bound holds wherever it ends. The interior point method of ``dwell`` finds the optimum to the last digit; over large
faces that takes up to forty times as long.
"""

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Indices, Scalars

_GAP = 0.004
"""Between the bound and a solution, relative: then it ends."""
_LOOK, _RESTART, _MOST = 100, 400, 8000
"""Iterations between two looks at the gap, between two restarts, and at most."""
_COLUMN_ROUNDS, _ROUGH = 7, 0.03
"""Programs with columns added, and the gap of the first: half of it in each that follows."""
_ADDED = 1500
"""Columns that a round adds at most: those that are overdrawn most."""
_RELAXED = 1.8
"""Of a step, in place of one: half the iterations, or a third."""
_ROUNDS, _EACH = 12, 400
"""Programs with the costs of groups laid anew, and iterations of each: a fixed number, so that rounding does not decide
where it ends."""
_SETTLED, _IDLE = 6, 0.5
"""Round from which on most groups are left out, and the least times of the others count; share of them that counts."""
_EPS_S = (2.0, 0.05)
"""Of the first and of the last rounds: the time of a group below which its fixed time is not counted in full."""
_UNUSED_S = 1e-3
_PREFERENCE = 0.2
"""Of the fixed time of a group: of equal groups the same one is taken however numbers are rounded."""


def least_time_bound(rates: csr_array, required: Scalars, first: Indices | None = None) -> float:
    """Time that no t >= 0 with ``rates @ t >= required`` is below in sum, at most about 1 % less than the least.

    By column generation: a program over some columns is solved, the columns that its multipliers overdraw are added,
    until none is overdrawn by more than 0.4 %. Multipliers of any program, scaled until no column of all is overdrawn,
    prove a bound of all, so that it holds wherever this ends.

    Args:
        rates: (m, n) at least 0; each row has an entry above 0.
        required: (m,) above 0.
        first: Columns of the first program, an entry above 0 in each row among them; left out, all.

    Returns:
        The bound, in the unit of t.
    """
    relative = _relative(rates, required)
    across = csr_array(relative.T)
    every = np.arange(relative.shape[1])
    some = every if first is None else first
    bound, multipliers, times = 0.0, np.zeros(relative.shape[0]), np.zeros(len(every))
    for number in range(_COLUMN_ROUNDS):
        gap = _GAP if first is None else max(_GAP, _ROUGH / 2**number)
        found, multipliers = _solve(csr_array(relative[:, some]), times[some], multipliers, gap)
        times[some] = found
        paid = np.asarray(across @ multipliers, dtype=np.float64)
        bound = max(bound, float(multipliers.sum() / max(paid.max(), 1e-12)))
        wrong = np.flatnonzero(paid > (1.0 + _GAP) * paid[some].max())
        if not len(wrong) and gap <= _GAP:
            break
        some = np.union1d(some, wrong[np.argsort(-paid[wrong], kind="stable")[:_ADDED]])
    return bound


def _solve(relative: csr_array, times: Scalars, multipliers: Scalars, gap: float) -> tuple[Scalars, Scalars]:
    """Times and multipliers of the best bound that proves itself to a gap, from those of a similar program."""
    across = csr_array(relative.T)
    bound, least, best = 0.0, np.inf, (times, multipliers)
    for candidates in _descend(relative, (times, multipliers), _MOST):
        for tried, prices in candidates:
            # Multipliers are feasible when they are scaled until no column is overdrawn, times until no row lacks any.
            proven = float(prices.sum() / max((across @ prices).max(), 1e-12))
            if proven > bound:
                bound, best = proven, (tried, prices)
            least = min(least, float(tried.sum() / max((relative @ tried).min(), 1e-12)))
        if least - bound <= gap * least:
            break
    return best


def times_of_few_groups(rates: csr_array, required: Scalars, group: Indices, least: Scalars, fixed_s: float) -> Scalars:
    """Find times t >= 0 with ``rates @ t >= required``, nearly, in few groups and of little sum.

    A group that is used costs a fixed time too, and half of what it is used for less than the least times of all its
    columns. That is not convex: it is approached by programs in which a second of a group costs 1 + fixed / (its time
    before + eps), eps smaller each time (Candes, Wakin and Boyd, Enhancing sparsity by reweighted l1 minimization,
    2008). What is found is good, and not proved the best.

    Args:
        rates: (m, n) at least 0; each row has an entry above 0.
        required: (m,) above 0.
        group: (n,) that each time belongs to, ascending from 0.
        least: (n,) what each takes at least where its group is used.
        fixed_s: What a group costs besides its times.

    Returns:
        (n,) times; those of groups that are left out are 0.
    """
    relative = _relative(rates, required)
    groups = int(group.max()) + 1
    fixed = fixed_s * (1.0 + _PREFERENCE * golden_shares(groups))
    times, multipliers, eps = np.zeros(len(group)), np.zeros(len(required)), _EPS_S[0]
    costs, used, whole = np.ones(groups), np.ones(groups, dtype=np.bool_), np.bincount(group, least, groups)
    for number in range(_ROUNDS):
        columns = np.flatnonzero(used[group])
        cost = costs[group[columns]]
        some = relative[:, columns]
        scaled = csr_array((some.data / cost[some.indices], some.indices, some.indptr), shape=some.shape)
        for candidates in _descend(scaled, (times[columns] * cost, multipliers), _EACH):
            paid, multipliers = candidates[-1]
            times = np.zeros(len(group))
            times[columns] = paid / cost
        spent = np.bincount(group, times, groups)
        used &= spent > _UNUSED_S
        idle = np.maximum(whole - spent, 0.0) if number >= _SETTLED else np.zeros(groups)
        costs = 1.0 + (fixed + _IDLE * idle) / (spent + eps)
        eps = max(eps / 2.0, _EPS_S[1])
    return np.where(used[group], times, 0.0)


def golden_shares(count: int) -> Scalars:
    """(count,) numbers from 0 to 1, all different and spread evenly: costs that differ by them have one least."""
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    return (np.arange(count) + 1) * golden % 1.0


def _relative(rates: csr_array, required: Scalars) -> csr_array:
    counts = np.diff(np.asarray(rates.indptr, dtype=np.int64))
    return csr_array((rates.data / np.repeat(required, counts), rates.indices, rates.indptr), shape=rates.shape)


def _descend(
    relative: csr_array, start: tuple[Scalars, Scalars], count: int
) -> Iterator[tuple[tuple[Scalars, Scalars], tuple[Scalars, Scalars]]]:
    """Times (n,) and multipliers (m,) of ``relative @ t >= 1``: the last ones and their means, every 100 iterations."""
    across = csr_array(relative.T)
    step, pull = (1.0 / np.maximum(np.asarray(relative.sum(axis=axis)).ravel(), 1e-12) for axis in (0, 1))
    x, y = start
    x_sum, y_sum, gathered = np.zeros(len(step)), np.zeros(len(pull)), 0
    for number in range(1, count + 1):
        times = np.maximum(x - step * (1.0 - across @ y), 0.0)
        multipliers = np.maximum(y + pull * (1.0 - relative @ (2.0 * times - x)), 0.0)
        x, y = x + _RELAXED * (times - x), y + _RELAXED * (multipliers - y)
        x_sum, y_sum, gathered = x_sum + times, y_sum + multipliers, gathered + 1
        if number % _LOOK:
            continue
        yield (times, multipliers), (x_sum / gathered, y_sum / gathered)
        if number % _RESTART == 0:
            x, y = x_sum / gathered, y_sum / gathered
            x_sum, y_sum, gathered = np.zeros_like(x), np.zeros_like(y), 0

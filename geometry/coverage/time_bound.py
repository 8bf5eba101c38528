"""A bound to the least time of dwelling: the linear program of ``dwell``, solved to a stated gap and no farther.

Primal-dual hybrid gradient with diagonal steps (Pock and Chambolle, Diagonal preconditioning for first order
primal-dual algorithms, 2011), over-relaxed, and restarted at the mean of its iterates (Applegate and others, Practical
large-scale linear programming using primal-dual hybrid gradient, 2021). Any multipliers bound the program, so that the
bound holds wherever it ends. The interior point method of ``dwell`` finds the optimum to the last digit; over large
faces that takes up to forty times as long.
"""

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Scalars

_GAP = 0.004
"""Between the bound and a solution, relative: then it ends."""
_LOOK, _RESTART, _MOST = 100, 400, 8000
"""Iterations between two looks at the gap, between two restarts, and at most."""
_RELAXED = 1.8
"""Of a step, in place of one: half the iterations, or a third."""


def least_time_bound(rates: csr_array, required: Scalars) -> float:
    """Time that no t >= 0 with ``rates @ t >= required`` is below in sum, at most 0.4 % less than the least.

    Args:
        rates: (m, n) at least 0; each row has an entry above 0.
        required: (m,) above 0.

    Returns:
        The bound, in the unit of t; where 8,000 iterations do not suffice, what they prove.
    """
    counts = np.diff(np.asarray(rates.indptr, dtype=np.int64))
    relative = csr_array((rates.data / np.repeat(required, counts), rates.indices, rates.indptr), shape=rates.shape)
    across = csr_array(relative.T)
    step, pull = (1.0 / np.maximum(np.asarray(relative.sum(axis=axis)).ravel(), 1e-12) for axis in (0, 1))
    x, y = np.zeros(len(step)), np.zeros(len(pull))
    x_sum, y_sum, gathered = np.zeros(len(step)), np.zeros(len(pull)), 0
    bound, least = 0.0, np.inf
    for number in range(1, _MOST + 1):
        times = np.maximum(x - step * (1.0 - across @ y), 0.0)
        multipliers = np.maximum(y + pull * (1.0 - relative @ (2.0 * times - x)), 0.0)
        x, y = x + _RELAXED * (times - x), y + _RELAXED * (multipliers - y)
        x_sum, y_sum, gathered = x_sum + times, y_sum + multipliers, gathered + 1
        if number % _LOOK:
            continue
        for some, other in ((times, multipliers), (x_sum / gathered, y_sum / gathered)):
            # Multipliers are feasible when they are scaled until no column is overdrawn, times until no row lacks any.
            bound = max(bound, float(other.sum() / max((across @ other).max(), 1e-12)))
            least = min(least, float(some.sum() / max((relative @ some).min(), 1e-12)))
        if least - bound <= _GAP * least:
            break
        if number % _RESTART == 0:
            x, y = x_sum / gathered, y_sum / gathered
            x_sum, y_sum, gathered = np.zeros_like(x), np.zeros_like(y), 0
    return bound

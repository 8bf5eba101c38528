"""The fastest clock that keeps to linear limits of its rate and of the change of that rate, stage by stage.

With x the squared rate at a sample and u its change, half of that of x for each second of the path, a stage has rows
-1 <= a u + b x <= 1. After Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
analysis" (2018): backwards the greatest x from which what follows can be kept, then forwards the greatest u. In two
unknowns neither takes a solver of linear programs: of a given x the rows bound u from below and from above, and the
two bounds meet where x is greatest. That standing still is always allowed makes 0 the least x everywhere.
"""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.compiled import compiled, inner

_SPARE = 1e-8
"""What a rate is below its greatest: what rounding adds must not leave the sets that the way back found,"""
_SPARE_SHARE = 0.9999
"""but not below this share of it."""


@compiled
def fastest_clock(length: Scalars, of_u: NDArray[np.float64], of_x: NDArray[np.float64], highest: Scalars) -> Scalars:
    """Give the squared rates (k + 1,) at the samples of a run that may begin and end at any rate.

    Args:
        length: (k,) of the stages, s of the path.
        of_u: (k, rows) a of the rows.
        of_x: (k, rows) b.
        highest: (k + 1,) greatest squared rates at the samples.
    """
    count = len(length)
    reach = np.empty(count + 1)
    reach[count] = highest[count]
    for at in range(count - 1, -1, -1):
        reach[at] = _greatest(length[at], of_u[at], of_x[at], highest[at], reach[at + 1])
    squared = np.empty(count + 1)
    squared[0] = _spared(reach[0])
    for at in range(count):
        _, _, change, _ = _bounds(length[at], of_u[at], of_x[at], squared[at], reach[at + 1])
        following = _spared(squared[at] + 2.0 * length[at] * change)
        squared[at + 1] = min(reach[at + 1], max(0.0, following))
    return squared


@inner
def _spared(squared: float) -> float:
    return max(squared - _SPARE, _SPARE_SHARE * squared)


@inner
def _greatest(length: float, of_u: Scalars, of_x: Scalars, highest: float, following: float) -> float:
    """Give the greatest x up to ``highest`` from which the next is at most ``following``.

    By how much the lower bound of u exceeds the upper one is convex in x: steps to where the rows that cross now meet
    come down to the answer, and end there.
    """
    x = highest
    for row in range(len(of_u)):
        if of_u[row] == 0.0 and abs(of_x[row]) * x > 1.0:
            x = 1.0 / abs(of_x[row])
    while x > 0.0:
        low, low_slope, high, high_slope = _bounds(length, of_u, of_x, x, following)
        if low <= high:
            break
        lower = x - (low - high) / (low_slope - high_slope)
        if not lower < x:  # rounding alone keeps the bounds apart
            break
        x = max(lower, 0.0)
    return x


@inner
def _bounds(
    length: float, of_u: Scalars, of_x: Scalars, x: float, following: float
) -> tuple[float, float, float, float]:
    """Give the bounds of u at an x, the lower with its slope over x, and the upper with its."""
    low, low_slope = -0.5 * x / length, -0.5 / length
    high, high_slope = 0.5 * (following - x) / length, -0.5 / length
    for row in range(len(of_u)):
        a, b = of_u[row], of_x[row]
        if a == 0.0:
            continue
        slope = -b / a
        size, middle = 1.0 / abs(a), slope * x
        if middle - size > low:
            low, low_slope = middle - size, slope
        if middle + size < high:
            high, high_slope = middle + size, slope
    return low, low_slope, high, high_slope

"""How sure a fit is: 95 % intervals by the jackknife where it is linear, by profile likelihood where it is not."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc, stdtrit

from geometry.arrays import Scalars

_LEVEL = 0.975
_TURNS = 40
_MOST_LEVERAGE = 1.0 - 1e-6
_VANISHING = 1e-100
"""A parameter to which no residual is more sensitive than this has no influence; its variance would be no number."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted value and its 95 % interval."""

    value: float
    low: float
    high: float
    """Infinite, as ``low`` may be 0, where the data do not bound it."""

    @property
    def interval(self) -> tuple[float, float]:
        """Lowest and highest."""
        return self.low, self.high


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Least squares: p parameters, n residuals."""

    parameters: Scalars
    """(p,)"""
    squares: float
    """Sum of the squared residuals."""
    freedom: int
    """Degrees of freedom: n less everything that was fitted."""
    jacobian: NDArray[np.float64]
    """(n, p) of the residuals at the optimum."""


def student_t(freedom: int) -> float:
    """Give Student's t for a two-sided 95 % interval."""
    return float(stdtrit(freedom, _LEVEL))


def half_widths(fit: Fit, residuals: NDArray[np.float64]) -> Scalars:
    """Give the half widths of 95 % intervals that hold where measurements scatter unevenly.

    The covariance is that of the jackknife, in its closed form for a linearised fit: each group of residuals that share
    an error is left out once (cluster-robust, CR3; with groups of one HC3, MacKinnon and White 1985). Student's t has
    as many degrees of freedom as there are groups beyond the parameters.

    Args:
        fit: Its n residuals are those of the groups, one group after the other.
        residuals: (g, k) of g groups, such as both edges of a row of a table.

    Returns:
        (p,) in the units of the parameters; infinite where the residuals do not depend on them.
    """
    inverse = _inverse(fit.jacobian)
    if not np.isfinite(inverse).all():
        return np.full(len(inverse), np.inf)
    groups, size = residuals.shape
    rows = fit.jacobian.reshape(groups, size, -1)
    hat = np.einsum("gip,pq,gjq->gij", rows, inverse, rows)
    left = np.linalg.solve(np.eye(size) - np.minimum(hat, _MOST_LEVERAGE), residuals[..., None])[..., 0]
    moved = np.einsum("pq,giq,gi->gp", inverse, rows, left)
    width = student_t(max(1, min(fit.freedom, groups - len(inverse))))
    return np.asarray(width * np.sqrt(np.sum(moved**2, axis=0)), dtype=np.float64)


def correlations(fit: Fit) -> NDArray[np.float64]:
    """(p, p) absolute correlations of the parameters of a linearised fit; 1 with itself, and where undetermined."""
    inverse = _inverse(fit.jacobian)
    if not np.isfinite(inverse).all():
        return np.ones_like(inverse)
    size = np.sqrt(np.diag(inverse))
    return np.asarray(np.abs(inverse) / np.outer(size, size), dtype=np.float64)


def _inverse(jacobian: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse of the normal matrix; infinite if it has none.

    The columns are brought to one size first: parameters in small units are no less determined for it, and squares of
    small numbers vanish.
    """
    count = jacobian.shape[1]
    none = np.full((count, count), np.inf)
    largest = np.abs(jacobian).max(axis=0, initial=0.0)
    if not np.isfinite(jacobian).all() or (largest < _VANISHING).any():
        return none
    size = largest * np.linalg.norm(jacobian / largest, axis=0)
    _, singular, rows = np.linalg.svd(jacobian / size, full_matrices=False)
    if len(singular) < count or (count and singular[-1] <= len(jacobian) * np.finfo(np.float64).eps * singular[0]):
        return none
    scaled = rows / singular[:, None]
    return np.asarray(scaled.T @ scaled / size / size[:, None], dtype=np.float64)


def chance_of_less(fewer: Fit, more: Fit) -> float:
    """Give the probability that parameters which mean nothing lower the squares as much as these did (F test)."""
    added = fewer.freedom - more.freedom
    ratio = ((fewer.squares - more.squares) / added) / max(more.squares / more.freedom, 1e-300)
    return float(fdtrc(added, more.freedom, max(ratio, 0.0)))


def highest_squares(squares: float, freedom: int) -> float:
    """Give the sum of squares up to which a value of one parameter lies in the 95 % profile interval."""
    return squares * (1.0 + student_t(freedom) ** 2 / freedom)


def profile_end(squares_at: Callable[[float], float], best: float, limit: float, most: float) -> float:
    """Search one end of a profile interval.

    Args:
        squares_at: Least sum of squares for a fixed value of the parameter.
        best: Its optimum.
        limit: Where the search ends, above or below the optimum.
        most: The sum of squares at the end of the interval.

    Returns:
        The end; infinite, with the sign of the direction, if the squares stay below up to the limit.
    """
    direction = math.copysign(1.0, limit - best)
    inside, step = best, 0.02
    while True:
        outside = best + direction * step
        if (outside - limit) * direction >= 0.0:
            outside = limit
        if squares_at(outside) > most:
            break
        if outside == limit:
            return direction * math.inf
        inside, step = outside, 2.0 * step
    for _ in range(_TURNS):
        if abs(outside - inside) < 1e-4:
            break
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if squares_at(middle) <= most else (inside, middle)
    return inside

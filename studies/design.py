"""Designs: the points at which the recipes' values are varied, and the deviations that are drawn; seeded."""

from collections.abc import Sequence
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from studies.study import Grid, Normal, Quantity, Study, Tolerances, Uniform, Variable, reach_of

Scalar: TypeAlias = float | int | str
Point: TypeAlias = tuple[Scalar, ...]
"""A value of each variable, in the order of the study."""
Deviation: TypeAlias = tuple[tuple[Quantity, float], ...]
"""How the carrying out deviates, in the units of the names; empty where it does not."""
_DIGITS = 6


def design_points(study: Study) -> list[Point]:
    """List the points of a study's design; one, without values, where nothing is varied."""
    if isinstance(study.design, Grid):
        return list(product(*(map(_short, _levels(each)) for each in study.variables)))
    unit = latin_hypercube(study.design.points, len(study.variables), study.design.seed)
    return [
        tuple(_short(_at(each, share)) for each, share in zip(study.variables, row, strict=True))
        for row in unit.tolist()
    ]


def draw_deviations(tolerances: Tolerances | None) -> list[Deviation]:
    """Draw deviations by a Latin hypercube; the same ones for every combination, so that these can be compared."""
    if tolerances is None:
        return []
    unit = latin_hypercube(tolerances.samples, len(tolerances.deviations), tolerances.seed)
    columns = [_quantiles(each, unit[:, at]) for at, each in enumerate(tolerances.deviations.values())]
    names = list(tolerances.deviations)
    return [
        tuple((name, float(f"{value:.{_DIGITS}g}")) for name, value in zip(names, row, strict=True))
        for row in zip(*columns, strict=True)
    ]


def latin_hypercube(points: int, variables: int, seed: int) -> NDArray[np.float64]:
    """(points, variables) shares of the ranges: in each variable one in each of as many equal parts, seeded.

    M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239.
    """
    from scipy.stats.qmc import LatinHypercube

    return LatinHypercube(variables, rng=np.random.default_rng(seed)).random(points)


def _quantiles(distribution: Normal | Uniform, shares: NDArray[np.float64]) -> list[float]:
    from scipy.stats import truncnorm

    if isinstance(distribution, Uniform):
        return (distribution.low + shares * (distribution.high - distribution.low)).tolist()
    low, high = ((end - distribution.mean) / distribution.sigma for end in reach_of(distribution))
    return truncnorm.ppf(shares, low, high, distribution.mean, distribution.sigma).tolist()


def _levels(variable: Variable) -> Sequence[Scalar]:
    return variable.values or np.linspace(*_range(variable), variable.steps or 1).tolist()


def _at(variable: Variable, share: float) -> Scalar:
    if variable.values is not None:
        return variable.values[min(int(share * len(variable.values)), len(variable.values) - 1)]
    low, high = _range(variable)
    return low + share * (high - low)


def _range(variable: Variable) -> tuple[float, float]:
    if variable.low is None or variable.high is None:
        raise AssertionError("a variable without values has a range: the study has been checked")
    return variable.low, variable.high


def _short(value: Scalar) -> Scalar:
    """Write a number as a person would: six digits, and whole ones without a point."""
    if isinstance(value, str):
        return value
    rounded = float(f"{value:.{_DIGITS}g}")
    return int(rounded) if rounded.is_integer() else rounded

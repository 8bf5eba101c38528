"""Minimum spraying times for which a forecast keeps its bounds, by linear programs, and the options for shortening.

The 5th percentile is not linear, for other places are the least wetted when the times change. So it is linearised
near the times of the last round, and these move a part of the way at a time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from geometry.arrays import Scalars
from rulesengine.tuning.changes.reductions import Reduction
from rulesengine.tuning.forecast.forecast import Forecast, LowerBound
from rulesengine.tuning.forecast.speed_curves import SpeedCurve
from rulesengine.tuning.variables.recipe_edits import Edits

_ROUNDS = 20
_REGION_FACTOR = 1.6
"""No time changes by more than this in one round."""
_CONVERGED = 1e-3
_PARTS = (1.0, 0.5, 0.25, 0.1)
_FEASIBLE = 1.0 - 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Scheme:
    """Bounds of the times, and what else changes."""

    bounds: Mapping[str, tuple[float, float]]
    """How many times as long each template may spray; those that are not named keep to 1."""
    fixed: Mapping[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    """How many times as long a template sprays in a step, by step and template, whatever its speed; else 1."""
    repeats: Mapping[str, float] = field(default_factory=dict[str, float])
    """How many times as often a step is done; else 1."""


@dataclass(frozen=True, slots=True, eq=False)
class MinimumTimes:
    """Times that keep all bounds, as predicted."""

    factors: Mapping[str, float]
    """How many times as long each template sprays by its speed alone."""
    times: Scalars
    """(deposits,) the same of each deposit, with what is fixed."""
    seconds: float
    """Of the program."""


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """A forecast and a scheme as arrays: deposit d sprays ``spread[d] @ x`` times as long."""

    forecast: Forecast
    scheme: Scheme
    lower_bounds: Sequence[LowerBound]
    spread: NDArray[np.float64]
    """(deposits, templates)"""
    low: Scalars
    high: Scalars

    def seconds(self, x: Scalars) -> float:
        return self.forecast.seconds(self.spread @ x, self.scheme.repeats)

    def worst_ratio(self, x: Scalars) -> float:
        """Least share of what is required; 1 where nothing is."""
        times = self.spread @ x
        durations = self.forecast.durations(times, self.scheme.repeats)
        return min((bound.amount(times, durations) / bound.least for bound in self.lower_bounds), default=1.0)


def minimum_times(forecast: Forecast, scheme: Scheme) -> MinimumTimes | None:
    """Minimum times within the scheme; ``None`` where none keep all bounds."""
    names = list(dict.fromkeys(deposit.template for deposit in forecast.deposits.each))
    problem = _problem(forecast, scheme, names)
    x = _start(problem)
    if x is None:
        return None
    for _ in range(_ROUNDS):
        goal = _solve(problem, x)
        moved = None if goal is None else _line_search(problem, x, goal)
        if moved is None:
            break
        converged = problem.seconds(x) - problem.seconds(moved) < _CONVERGED * problem.seconds(x)
        x = moved
        if converged:
            break
    return MinimumTimes(dict(zip(names, x.tolist(), strict=True)), problem.spread @ x, problem.seconds(x))


def _problem(forecast: Forecast, scheme: Scheme, names: list[str]) -> _Problem:
    each = forecast.deposits.each
    spread = np.zeros((len(each), len(names)))
    for row, deposit in enumerate(each):
        spread[row, names.index(deposit.template)] = scheme.fixed.get((deposit.step, deposit.template), 1.0)
    longest: dict[frozenset[str], LowerBound] = {}  # of the bounds on time of the same steps, the highest
    for bound in forecast.bounds:
        if bound.kind == "time" and (bound.steps not in longest or bound.least > longest[bound.steps].least):
            longest[bound.steps] = bound
    amounts = [bound for bound in forecast.bounds if bound.kind != "time"]
    active = [bound for bound in (*amounts, *longest.values()) if bound.least > 0]
    low, high = np.array([scheme.bounds.get(name, (1.0, 1.0)) for name in names]).reshape(-1, 2).T
    return _Problem(forecast, scheme, active, spread, low, high)


def _start(problem: _Problem) -> Scalars | None:
    """Keep the times, or make all of them as much longer as it takes."""
    longer = 1.0
    for _ in range(_ROUNDS):
        x = np.clip(longer, problem.low, problem.high)
        worst = problem.worst_ratio(x)
        if worst >= _FEASIBLE:
            return x
        if (x >= problem.high).all() or worst <= 0:
            return None
        longer *= max(1.0 / worst, 1.02)
    return None


def _solve(problem: _Problem, x: Scalars) -> Scalars | None:
    """Solve the problem linearised near ``x``."""
    deposits, repeats = problem.forecast.deposits.each, problem.scheme.repeats
    seconds = np.array([deposit.seconds for deposit in deposits])
    rows, least = [np.empty((0, len(x)))], [np.empty(0)]
    times = problem.spread @ x
    for bound in problem.lower_bounds:
        if bound.kind == "time":
            of_step = np.array([deposit.step in bound.steps for deposit in deposits])
            idle = sum(problem.forecast.idle_s[step] * repeats.get(step, 1.0) for step in bound.steps)
            rows.append((seconds * of_step @ problem.spread)[None])
            least.append(np.array([bound.least - idle]))
        else:
            rows.append((bound.slopes(times) @ problem.spread[list(bound.which)])[None])
            least.append(np.array([bound.least]))
    region = np.column_stack(
        [np.maximum(problem.low, x / _REGION_FACTOR), np.minimum(problem.high, x * _REGION_FACTOR)]
    )
    scale = np.maximum(np.abs(np.concatenate(least)), 1e-9)
    found = linprog(
        seconds @ problem.spread, -np.concatenate(rows) / scale[:, None], -np.concatenate(least) / scale, bounds=region
    )
    return np.asarray(found.x) if found.success else None


def _line_search(problem: _Problem, x: Scalars, goal: Scalars) -> Scalars | None:
    """Go as far towards a goal as keeps the bounds and saves time."""
    for part in _PARTS:
        moved = x + part * (goal - x)
        for margin in (1.0, 1.02, 1.05):  # a little more of everything makes up for what is not linear
            tried = np.clip(moved * margin, problem.low, problem.high)
            if problem.seconds(tried) < problem.seconds(x) and problem.worst_ratio(tried) >= _FEASIBLE:
                return tried
    return None


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """One option for a shorter recipe."""

    name: str
    """Empty: nothing but speeds change."""
    what: tuple[str, ...]
    """What else changes, from and to."""
    edits: Edits
    scheme: Scheme
    found: MinimumTimes


def shortening_options(
    predicted: Forecast, curves: Mapping[str, SpeedCurve], reductions: Mapping[str, Reduction]
) -> list[Option]:
    """Predict the shortest program with other speeds alone, with each smaller whole number, with each path left out.

    The shortest comes first.
    """
    bounds = {name: curve.bounds for name, curve in curves.items()}
    schemes: list[tuple[str, tuple[str, ...], Edits, Scheme]] = [("", (), (), Scheme(bounds))]
    sources = [(deposit.step, deposit.template) for deposit in predicted.deposits.each]
    for each in reductions.values():
        for value in _whole_values(each):
            ratio = 0.0 if each.variable is None else value / each.variable.value
            fixed = {
                (step, template): ratio
                for step, template in sources
                if step in each.steps and each.template in ("", template)
            }
            repeats = {} if each.template else dict.fromkeys(each.steps, ratio)
            what, edits = each.change_to(value)
            schemes.append((f"{each.name} {value:g}", (what,), edits, Scheme(bounds, fixed, repeats)))
    timed = [(scheme, minimum_times(predicted, scheme[3])) for scheme in schemes]
    found = [Option(*scheme, times) for scheme, times in timed if times is not None]
    return sorted(found, key=lambda option: round(option.found.seconds, 3))


def _whole_values(reduction: Reduction) -> list[float]:
    variable, end = reduction.variable, reduction.end
    if variable is None:
        return [end]
    if variable.kind == "speeds" or reduction.is_unknown:
        return []
    values = (end, reduction.bisect(reduction.begin, end), reduction.begin - 1.0)
    return list(dict.fromkeys(value for value in values if value is not None and value >= end))

"""Minimum spraying times for which a forecast keeps its bounds, by linear programs, and the options for shortening.

And speeds for these times, by planning: around small parts a nozzle does not reach its speed.

The 5th percentile is not linear, for other places are the least wetted when the times change. So it is linearised
near the times of the last round, and these move a part of the way at a time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import floor

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from geometry.arrays import Scalars
from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.changes.reductions import Reduction
from rulesengine.tuning.forecast.forecast import Forecast, LowerBound
from rulesengine.tuning.trial.outcome import Outcome, SprayTimes
from rulesengine.tuning.trial.request import AllowedChanges
from rulesengine.tuning.trial.trial_runner import Candidate, TrialRunner
from rulesengine.tuning.variables import DesignVariable, Edits

_PLANS = 4
_NEAR = 0.01
"""A time is met within this share."""
_FASTER, _SLOWER = 3.0, 4.0
"""How many times a speed may change at once."""


@dataclass(frozen=True, slots=True, eq=False)
class SpeedCurve:
    """Spraying time of one template over its speed, relative to the present time."""

    variable: DesignVariable
    """Its present speed."""
    factors: Mapping[float, float]
    """By speed: the present one, the least and the greatest that are tried."""

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest factor."""
        return min(self.factors.values()), max(self.factors.values())

    def speed(self, factor: float) -> float:
        """Speed for a factor, interpolated: times go with the inverse of the speed between two that are known."""
        variable, points = self.variable, sorted(self.factors.items(), key=lambda each: each[1])
        target = max(factor, (1.0 + _NEAR) * points[0][1])
        at = next((at for at, (_, known) in enumerate(points) if known >= target), None)
        if at is None:
            return points[-1][0]
        (fast, short), (slow, long) = points[max(at - 1, 0)], points[at]
        share = (target - short) / (long - short) if long > short else 1.0
        value = 1.0 / ((1.0 - share) / fast + share / slow)
        resolution = variable.resolution
        return min(max(resolution * floor(value / resolution + 1e-6), variable.lower), variable.upper)


@dataclass(frozen=True, slots=True, eq=False)
class SpeedPlan:
    """A recipe whose templates spray about as long as is required."""

    candidate: Candidate
    what: tuple[str, ...]
    """The speeds that changed, from and to."""
    times: SprayTimes
    """As planned."""


def tunable_speeds(allowed: AllowedChanges, outcome: Outcome) -> dict[str, DesignVariable]:
    """Speed of each template that may be changed: one number for all classes, and not of a drying step."""
    drying = {step.made_by for step in outcome.steps if step.use == "dry"}
    return {
        variable.template: variable
        for variable in variables_of(outcome)
        if variable.kind == "speeds"
        and not drying & set(variable.steps)
        and not variable.component_class
        and allowed.permits("speeds", ((variable.path, None),))
    }


def speed_curves(runner: TrialRunner, text: str, speeds: Mapping[str, DesignVariable]) -> dict[str, SpeedCurve]:
    """Plan a recipe with the speeds of its templates as high and as low as they may become."""
    now = runner.spray_durations(text)
    found = {name: {variable.value: 1.0} for name, variable in speeds.items() if _total(now, name) > 0}
    for times in (_FASTER, 1.0 / _SLOWER):
        values = {
            name: each.rounded(min(max(each.value * times, each.lower), each.upper))
            for name, each in speeds.items()
            if name in found
        }
        changed = runner.candidate(text, tuple(edit for name in found for edit in speeds[name].edit(values[name])))
        sprayed = {} if changed is None else runner.spray_durations(changed.text)
        for name in found if sprayed else ():
            found[name][values[name]] = _total(sprayed, name) / _total(now, name)
    return {name: SpeedCurve(speeds[name], factors) for name, factors in found.items()}


def plan_speeds(
    runner: TrialRunner,
    recipe: tuple[str, Edits],
    curves: Mapping[str, SpeedCurve],
    required: SprayTimes,
    factors: Mapping[str, float],
) -> SpeedPlan | None:
    """Find speeds for required times; ``None`` where the recipe, a text with other edits, cannot be planned.

    ``factors`` are those of each template by its speed alone.
    """
    text, edits = recipe
    for left in reversed(range(_PLANS)):
        values = {name: curve.speed(factors[name]) for name, curve in curves.items()}
        changed = [
            (curve.variable, values[name]) for name, curve in curves.items() if values[name] != curve.variable.value
        ]
        candidate = runner.candidate(text, (*edits, *(edit for each, value in changed for edit in each.edit(value))))
        times = {} if candidate is None else runner.spray_durations(candidate.text)
        if candidate is None or not times:
            return None
        better: dict[str, SpeedCurve] = {}
        for name, curve in curves.items():
            target = _total(required, name)
            ratio = _total(times, name) / target if target > 0 else 1.0
            known = {speed for speed in curve.factors if speed != curve.variable.value}
            if abs(ratio - 1.0) >= _NEAR and values[name] not in known:
                curve = replace(curve, factors={**curve.factors, values[name]: factors[name] * ratio})
            better[name] = curve
        if not left or all(curve.speed(factors[name]) == values[name] for name, curve in better.items()):
            return SpeedPlan(candidate, tuple(each.describe(value) for each, value in changed), times)
        curves = better
    return None


def _total(times: SprayTimes, name: str) -> float:
    return sum(seconds for (_, template), seconds in times.items() if template == name)


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

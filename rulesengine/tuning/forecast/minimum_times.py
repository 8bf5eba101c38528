"""The shortest times to spray for which a forecast still holds: linear programs, one after the other.

What the least wetted places get is no linear matter, for other places are the least wetted when the times change. So
it is taken for linear near the times of the last round, and these move a part of the way at a time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from geometry.arrays import Scalars
from rulesengine.tuning.forecast.forecast import Forecast
from rulesengine.tuning.trial.lower_bound import Need

_ROUNDS = 20
_WAY = 1.6
"""No time changes by more than this in one round."""
_SETTLED = 1e-3
_PARTS = (1.0, 0.5, 0.25, 0.1)


@dataclass(frozen=True, slots=True, eq=False)
class Scheme:
    """What is given, and how far the times may go."""

    bounds: Mapping[str, tuple[float, float]]
    """How many times as long each template may spray; those that are not named keep to 1."""
    given: Mapping[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    """How many times as long a template sprays in a step, by step and template, whatever its speed; else 1."""
    often: Mapping[str, float] = field(default_factory=dict[str, float])
    """How many times as often a step is done; else 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Shortest:
    """Times that hold, as far as a forecast can tell."""

    factors: Mapping[str, float]
    """How many times as long each template sprays by its speed alone."""
    times: Scalars
    """(deposits,) the same of each deposit, with what is given."""
    seconds: float
    """Of the program."""


@dataclass(frozen=True, slots=True, eq=False)
class _Case:
    """A forecast and a scheme as arrays: deposit d sprays ``spread[d] @ x`` times as long."""

    forecast: Forecast
    scheme: Scheme
    needs: Sequence[Need]
    spread: NDArray[np.float64]
    """(deposits, templates)"""
    low: Scalars
    high: Scalars

    def times(self, x: Scalars) -> Scalars:
        return self.spread @ x

    def seconds(self, x: Scalars) -> float:
        return self.forecast.seconds(self.times(x), self.scheme.often)

    def ratios(self, x: Scalars) -> Scalars:
        """(needs,) What each gets of what it needs."""
        times = self.times(x)
        durations = self.forecast.durations(times, self.scheme.often)
        return np.array([need.amount(times, durations) / need.least for need in self.needs])


def shortest(forecast: Forecast, scheme: Scheme) -> Shortest | None:
    """Find the times; ``None`` where none within the bounds hold.

    Args:
        forecast: What must hold.
        scheme: What is given.
    """
    case = _case_of(forecast, scheme)
    x = _begin(case)
    if x is None:
        return None
    for _ in range(_ROUNDS):
        step = _solve(case, x)
        moved = None if step is None else _part(case, x, step)
        if moved is None:
            break
        settled = case.seconds(x) - case.seconds(moved) < _SETTLED * case.seconds(x)
        x = moved
        if settled:
            break
    names = _templates(forecast)
    return Shortest(dict(zip(names, x.tolist(), strict=True)), case.times(x), case.seconds(x))


def _templates(forecast: Forecast) -> list[str]:
    return list(dict.fromkeys(deposit.template for deposit in forecast.deposits.each))


def _case_of(forecast: Forecast, scheme: Scheme) -> _Case:
    names, each = _templates(forecast), forecast.deposits.each
    spread = np.zeros((len(each), len(names)))
    for row, deposit in enumerate(each):
        spread[row, names.index(deposit.template)] = scheme.given.get((deposit.step, deposit.template), 1.0)
    bounds = [scheme.bounds.get(name, (1.0, 1.0)) for name in names]
    longest: dict[frozenset[str], Need] = {}  # of those that ask for time, the greediest stands for all
    for need in forecast.needs:
        if need.kind == "time" and (need.steps not in longest or need.least > longest[need.steps].least):
            longest[need.steps] = need
    needs = [need for need in forecast.needs if need.least > 0 and need.kind != "time"]
    needs += [need for need in longest.values() if need.least > 0]
    return _Case(
        forecast, scheme, needs, spread, np.array([low for low, _ in bounds]), np.array([high for _, high in bounds])
    )


def _begin(case: _Case) -> Scalars | None:
    """Keep the times, or make all of them as much longer as it takes."""
    longer = 1.0
    for _ in range(_ROUNDS):
        x = np.clip(longer, case.low, case.high)
        worst = float(case.ratios(x).min(initial=1.0))
        if worst >= 1.0 - 1e-9:
            return x
        if (x >= case.high).all() or worst <= 0:
            return None
        longer *= max(1.0 / worst, 1.02)
    return None


def _solve(case: _Case, x: Scalars) -> Scalars | None:
    """Solve what is linear near ``x``."""
    seconds = np.array([deposit.seconds for deposit in case.forecast.deposits.each])
    rows, least = [np.empty((0, len(x)))], [np.empty(0)]
    times = case.times(x)
    for need in case.needs:
        if need.kind == "time":
            of_step = np.array([deposit.step in need.steps for deposit in case.forecast.deposits.each])
            idle = sum(case.forecast.idle_s[step] * case.scheme.often.get(step, 1.0) for step in need.steps)
            rows.append((seconds * of_step @ case.spread)[None])
            least.append(np.array([need.least - idle]))
        else:
            rows.append((need.slopes(times) @ case.spread[list(need.which)])[None])
            least.append(np.array([need.least]))
    bounds = np.column_stack([np.maximum(case.low, x / _WAY), np.minimum(case.high, x * _WAY)])
    scale = np.maximum(np.abs(np.concatenate(least)), 1e-9)
    found = linprog(
        seconds @ case.spread, -np.concatenate(rows) / scale[:, None], -np.concatenate(least) / scale, bounds=bounds
    )
    return np.asarray(found.x) if found.success else None


def _part(case: _Case, x: Scalars, goal: Scalars) -> Scalars | None:
    """Go as far towards a goal as holds and saves time."""
    for part in _PARTS:
        moved = x + part * (goal - x)
        # A little more of everything makes up for what is not linear.
        for more in (1.0, 1.02, 1.05):
            more_of = np.clip(moved * more, case.low, case.high)
            if case.seconds(more_of) < case.seconds(x) and case.ratios(more_of).min(initial=1.0) >= 1.0 - 1e-9:
                return more_of
    return None

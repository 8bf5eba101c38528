"""Speeds for required spraying times, by planning: around small parts a nozzle does not reach its speed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import floor
from typing import TypeAlias

from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import AllowedChanges
from rulesengine.tuning.trial.trial_runner import Candidate, TrialRunner
from rulesengine.tuning.variables.design_variables import DesignVariable
from rulesengine.tuning.variables.recipe_edits import Edits

_ROUNDS = 4
_NEAR = 0.01
"""A time is met within this share."""
_FASTER, _SLOWER = 3.0, 4.0
"""How many times a speed may change at once."""

SprayTimes: TypeAlias = Mapping[tuple[str, str], float]
"""Seconds by step and template."""


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
    for left in reversed(range(_ROUNDS)):
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

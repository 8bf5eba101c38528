"""Speeds for asked times: around small parts a nozzle does not reach its speed, so that plans tell the times."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import floor
from typing import TypeAlias

from rulesengine.tuning.trial.trial_runner import Bench
from rulesengine.tuning.variables.design_variables import Knob
from rulesengine.tuning.variables.recipe_edits import Edits

_ROUNDS = 4
_NEAR = 0.01
"""A time is met within this share."""
_FASTER, _SLOWER = 3.0, 4.0
"""How many times a speed may change at once."""


Sprayed: TypeAlias = Mapping[tuple[str, str], float]
"""Seconds by step and template."""


@dataclass(frozen=True, slots=True, eq=False)
class Pace:
    """How many times as long as now one template sprays at other speeds."""

    knob: Knob
    """Its speed as it is."""
    factors: Mapping[float, float]
    """By speed: the present one, the least and the greatest that are tried."""

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest factor."""
        return min(self.factors.values()), max(self.factors.values())

    def speed(self, factor: float) -> float:
        """Find the speed for a factor: times go with the inverse of the speed between two that are known."""
        points = sorted(self.factors.items(), key=lambda each: each[1])
        asked = max(factor, (1.0 + _NEAR) * points[0][1])
        at = next((at for at, (_, known) in enumerate(points) if known >= asked), None)
        if at is None:
            return points[-1][0]
        (fast, short), (slow, long) = points[max(at - 1, 0)], points[at]
        share = (asked - short) / (long - short) if long > short else 1.0
        value = 1.0 / ((1.0 - share) / fast + share / slow)
        return min(max(self.knob.grain * floor(value / self.knob.grain + 1e-6), self.knob.least), self.knob.most)


@dataclass(frozen=True, slots=True, eq=False)
class Paced:
    """A recipe whose templates spray about as long as was asked."""

    text: str
    what: tuple[str, ...]
    """The speeds that changed, from and to."""
    sprayed_s: Sprayed
    """As planned."""


def paces_of(bench: Bench, text: str, speeds: Mapping[str, Knob]) -> dict[str, Pace]:
    """Plan a recipe with all of some speeds as high and as low as they may become.

    Args:
        bench: Where to plan.
        text: The recipe.
        speeds: By template; what cannot be planned keeps its speed.
    """
    now = bench.sprayed_s(text)
    found = {name: {knob.value: 1.0} for name, knob in speeds.items() if _total(now, name) > 0}
    for times in (_FASTER, 1.0 / _SLOWER):
        values = {name: _within(speeds[name], speeds[name].value * times) for name in found}
        changed = bench.edited(text, tuple(edit for name in found for edit in speeds[name].edit(values[name])))
        sprayed = {} if changed is None else bench.sprayed_s(changed)
        for name in found if sprayed else ():
            found[name][values[name]] = _total(sprayed, name) / _total(now, name)
    return {name: Pace(speeds[name], factors) for name, factors in found.items()}


def pace(
    bench: Bench, text: str, edits: Edits, paces: Mapping[str, Pace], asked_s: Sprayed, factors: Mapping[str, float]
) -> Paced | None:
    """Find the speeds; ``None`` where the recipe cannot be planned.

    Args:
        bench: Where to plan.
        text: The recipe.
        edits: What else changes.
        paces: By template.
        asked_s: How long each is to spray.
        factors: How many times as long as now by its speed alone, by template.
    """
    for left in reversed(range(_ROUNDS)):
        values = {name: each.speed(factors[name]) for name, each in paces.items()}
        turned = [(each.knob, values[name]) for name, each in paces.items() if values[name] != each.knob.value]
        changed = bench.edited(text, (*edits, *(edit for knob, value in turned for edit in knob.edit(value))))
        sprayed = {} if changed is None else bench.sprayed_s(changed)
        if changed is None or not sprayed:
            return None
        better = {
            name: _corrected(each, values[name], factors[name], _ratio(sprayed, asked_s, name))
            for name, each in paces.items()
        }
        if not left or all(each.speed(factors[name]) == values[name] for name, each in better.items()):
            return Paced(changed, tuple(knob.told(value) for knob, value in turned), sprayed)
        paces = better
    return None


def _corrected(pace: Pace, value: float, factor: float, ratio: float) -> Pace:
    """Keep in mind what a speed came to; a little off is near enough."""
    if abs(ratio - 1.0) < _NEAR or value in (known for known in pace.factors if known != pace.knob.value):
        return pace
    return replace(pace, factors={**pace.factors, value: factor * ratio})


def _ratio(sprayed_s: Sprayed, asked_s: Sprayed, name: str) -> float:
    asked = _total(asked_s, name)
    return _total(sprayed_s, name) / asked if asked > 0 else 1.0


def _within(knob: Knob, value: float) -> float:
    return knob.moved(min(max(value, knob.least), knob.most))


def _total(sprayed_s: Sprayed, name: str) -> float:
    return sum(seconds for (_, template), seconds in sprayed_s.items() if template == name)

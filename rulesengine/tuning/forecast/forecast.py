"""Forecast of an outcome at other spraying times: amounts and times add up, so that no analysis is needed.

On exposed surfaces that is exact but for the grain of the rays. What else the model knows of (pressure at edges, flow
and rinsing under parts) is left to analyses: where one finds less than was predicted, the bound is raised from then on.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.verdicts import rules
from cleaning.verdicts.exposed_area import FEW, LOW, low_value, percentile
from geometry.arrays import Scalars
from rulesengine.tuning.changes.candidate_changes import is_unreached, steps_for
from rulesengine.tuning.trial.outcome import Deposits, Outcome
from rulesengine.tuning.trial.requirements import Key, MetRequirement, Requirement, UnmetRequirement
from rulesengine.tuning.variables import enabled_steps

BoundKind: TypeAlias = Literal["low", "mean", "time"]
"""What stands for the least wetted places, the mean by area (mm of liquid), or how long the steps take (s)."""
_BAND = (0.02, 0.08)
"""Cells around the 5th percentile, which stand for it."""
_SAFETY = 1.01
_MOST_DEFICIT = 0.8
_MOST_MARGIN_GROWTH = 1.25
"""No margin grows by more at once: where a part has few cells, chance decides much of what the least wetted gets."""
_LOW_MARGIN = 1.03
"""What the least wetted places are to get more than they need."""
_NO_CELLS = np.empty(0, dtype=np.int64)
_FLOW_RULES = (rules.NOT_FLUSHED, rules.INCOMPLETE_RINSE, rules.IONIC_RESIDUE)
_AMOUNT_RULES = (rules.UNDER_EXPOSED, rules.RESIDUE_LEFT, *_FLOW_RULES)


@dataclass(frozen=True, slots=True, eq=False)
class LowerBound:
    """An amount or a time that must not become less than ``least``."""

    key: Key
    kind: BoundKind
    least: float
    steps: frozenset[str]
    which: tuple[int, ...]
    """Deposits of these steps."""
    volumes: NDArray[np.float64]
    """(deposits, cells) mm"""
    areas: Scalars
    """(cells,)"""

    def amount(self, times: Scalars, durations: Mapping[str, float]) -> float:
        """Predict the amount or time, with each of all deposits sprayed so many times as long."""
        if self.kind == "time":
            return sum(durations[step] for step in self.steps)
        if not len(self.areas):
            return 0.0
        found = times[list(self.which)] @ self.volumes
        if self.kind == "low":
            return low_value(found, self.areas)
        return float(np.average(found, weights=self.areas))

    def slopes(self, times: Scalars) -> Scalars:
        """(deposits of it,) Derivatives of the amount near ``times``; with these it adds up to the amount."""
        if self.kind == "mean":
            return np.average(self.volumes, axis=1, weights=self.areas)
        found = times[list(self.which)] @ self.volumes
        order = np.argsort(found, kind="stable")
        reached = np.cumsum(self.areas[order]) / self.areas.sum()
        first, last = np.searchsorted(reached, _BAND)
        low = low_value(found, self.areas)
        near = order[first : last + 1] if low <= percentile(found, self.areas, LOW) else order[:FEW]
        mean = float(np.average(found[near], weights=self.areas[near]))
        scale = low / mean if mean > 0 else 0.0
        return scale * np.average(self.volumes[:, near], axis=1, weights=self.areas[near])


@dataclass(slots=True)
class Corrections:
    """Corrections of forecasts, learnt from analyses that found less than was predicted."""

    margins: dict[Key, float] = field(default_factory=dict[Key, float])
    """Factors on bounds."""
    means: dict[Key, tuple[float, frozenset[str]]] = field(default_factory=dict[Key, tuple[float, frozenset[str]]])
    """Mean amounts that are needed for what does not depend on the surface, and of which steps."""

    def relax(self) -> None:
        """Halve the margins, by their logarithms: forecasts from another outcome may err elsewhere."""
        self.margins = {key: margin**0.5 for key, margin in self.margins.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Forecast:
    """An outcome taken apart by deposits, so that others near it can be predicted."""

    outcome: Outcome
    deposits: Deposits
    idle_s: Mapping[str, float]
    """Time of each step without spraying."""
    rest_s: float
    """Outside of all steps that spray."""
    bounds: tuple[LowerBound, ...]
    owed: frozenset[Key] = frozenset()
    """Requirements that are not met yet and have to be, where others only must not lose."""

    def durations(self, times: Scalars, repeats: Mapping[str, float]) -> dict[str, float]:
        """Predict the durations of the steps, s, done so many times as often; once where they are not named."""
        found = {step: idle * repeats.get(step, 1.0) for step, idle in self.idle_s.items()}
        for deposit, many in zip(self.deposits.each, times.tolist(), strict=True):
            found[deposit.step] += many * deposit.seconds
        return found

    def seconds(self, times: Scalars, repeats: Mapping[str, float]) -> float:
        """Predict the duration of the program, s."""
        return self.rest_s + sum(self.durations(times, repeats).values())


def forecast(
    outcome: Outcome,
    corrections: Corrections,
    unattainable: frozenset[Key] = frozenset(),
    owed: frozenset[Key] = frozenset(),
) -> Forecast:
    """Take an outcome apart: what is met must stay met, what is not must not lose.

    Args:
        outcome: As it was analysed.
        corrections: What earlier forecasts taught.
        unattainable: Requirements that do not count.
        owed: Requirements that are not met and have to be.
    """
    deposits = outcome.deposits
    idle = {step.made_by: step.seconds for step in outcome.steps}
    for deposit in deposits.each:
        idle[deposit.step] -= deposit.seconds
    rest = outcome.seconds - sum(step.seconds for step in outcome.steps)
    bounds: list[LowerBound] = []
    for met in outcome.met:
        share = met.needed * corrections.margins.get(met.key, 1.0)
        bounds.append(
            _time_bound(met, outcome, share)
            if met.rule == rules.RESIDUE_LEFT
            else _low_bound(met, outcome, _LOW_MARGIN * share)
        )
    bounds += [
        bound
        for unmet in outcome.attainable
        if unmet.key not in unattainable
        for bound in _of_unmet(unmet, outcome, corrections.margins.get(unmet.key, 1.0) if unmet.key in owed else None)
    ]
    bounds += [_surface_bound(key, "mean", steps, outcome, least) for key, (least, steps) in corrections.means.items()]
    return Forecast(outcome, deposits, idle, rest, tuple(bounds), owed)


def unattainable(outcome: Outcome, longest: Mapping[str, float]) -> frozenset[Key]:
    """Requirements that no spraying time meets: not a matter of amounts, or out of reach of the longest times.

    ``longest`` is relative to the present times, by template; 1 for those that are not named.
    """
    times = np.array([longest.get(deposit.template, 1.0) for deposit in outcome.deposits.each])
    found = {each.key for each in outcome.unmet if each.rule not in _AMOUNT_RULES or is_unreached(each)}
    for unmet in outcome.attainable:
        if unmet.rule == rules.UNDER_EXPOSED and not is_unreached(unmet):
            bound = _low_bound(unmet, outcome, 1.0 / (1.0 - unmet.deficit))
            found |= {bound.key} if bound.amount(times, {}) < bound.least else set()
    # Where much of a surface is missed, amounts are not judged; they are as soon as a little less is missed.
    missed = [each for each in outcome.unmet if each.rule == rules.MISSED and each.judgement.verdict == "dirty"]
    return frozenset(found | {(each.component, rules.UNDER_EXPOSED, str(each.judgement.stage)) for each in missed})


def correct(
    corrections: Corrections, predicted: Forecast, found: Outcome, times: Scalars, repeats: Mapping[str, float]
) -> bool:
    """Raise the bounds of requirements that were predicted to be met and are not; ``False`` if there is none."""
    durations = predicted.durations(times, repeats)
    before = {each.key: each.deficit for each in predicted.outcome.unmet if each.key not in predicted.owed}
    bounds = {bound.key: bound for bound in predicted.bounds}
    corrected = 0
    for unmet in found.unmet:
        if unmet.deficit <= before.get(unmet.key, -1.0):
            continue
        bound = bounds.get(unmet.key)
        if bound is not None and bound.kind != "mean":
            margin = corrections.margins.get(unmet.key, 1.0)
            promised = bound.amount(times, durations) * margin / bound.least
            needed = _SAFETY * promised / (1.0 - min(unmet.deficit, _MOST_DEFICIT))
            corrections.margins[unmet.key] = min(needed, _MOST_MARGIN_GROWTH * max(margin, promised))
            corrected += 1
            continue
        # More than the amount that was too little, less than the one that was enough.
        steps = steps_for(unmet, predicted.outcome)
        mean = _surface_bound(unmet.key, "mean", steps, predicted.outcome, 0.0)
        had, gets = mean.amount(np.ones(len(times)), {}), mean.amount(times, {})
        if gets < had:
            corrections.means[unmet.key] = (had * gets) ** 0.5, steps
            corrected += 1
    return corrected > 0


def _of_unmet(unmet: UnmetRequirement, outcome: Outcome, owed: float | None) -> Iterator[LowerBound]:
    """An amount that is too small is required in full; of what else is not met, there shall be no less.

    With a factor ``owed`` that is required in full too, so many times: amounts and times grow by what is missing.
    """
    rule = unmet.rule
    in_full = 1.0 / (1.0 - min(unmet.deficit, _MOST_DEFICIT))
    share = 1.0 if owed is None else owed * in_full
    if rule == rules.RESIDUE_LEFT:
        yield _time_bound(unmet, outcome, share)
    elif rule == rules.UNDER_EXPOSED and not is_unreached(unmet):
        yield _low_bound(unmet, outcome, 1.0 / (1.0 - unmet.deficit) if owed is None else share)
    elif rule in _FLOW_RULES and unmet.deficit < 1.0:
        bound = _surface_bound(unmet.key, "mean", steps_for(unmet, outcome), outcome, 0.0)
        yield replace(bound, least=share * bound.amount(np.ones(len(outcome.deposits.each)), {}))


def _time_bound(of: Requirement, outcome: Outcome, share: float) -> LowerBound:
    steps = steps_for(of, outcome)
    return LowerBound(of.key, "time", share * outcome.seconds_in(steps), steps, (), np.empty((0, 0)), np.empty(0))


def _low_bound(of: MetRequirement | UnmetRequirement, outcome: Outcome, share: float) -> LowerBound:
    """Bound on the least wetted places; without a step, of the sum of steps nearest to the value of the judgement."""
    now = np.ones(len(outcome.deposits.each))
    value = of.judgement.numbers[0].value
    groups = [frozenset({str(of.judgement.stage)})]
    if not of.judgement.stage:
        sides = _sides(outcome)
        of_key: dict[tuple[Side, str | None], set[str]] = {}
        for step, side in sides.items():
            of_key.setdefault((side, outcome.use_of(step)), set()).add(step)
        groups = [frozenset(steps) for steps in of_key.values()]
    found = [_surface_bound(of.key, "low", steps, outcome, 0.0) for steps in groups]
    amounts = [bound.amount(now, {}) for bound in found]
    nearest = min(range(len(found)), key=lambda at: abs(amounts[at] - value))
    return replace(found[nearest], least=share * amounts[nearest])


def _sides(outcome: Outcome) -> dict[str, Side]:
    known = {deposit.step for deposit in outcome.deposits.each}
    return {made_by: step.side for made_by, step in enabled_steps(outcome.recipe) if made_by in known}


def _surface_bound(key: Key, kind: BoundKind, steps: frozenset[str], outcome: Outcome, least: float) -> LowerBound:
    """Bound on what some steps, all on one side, leave on the surface of a component."""
    deposits = outcome.deposits
    sides: list[Side] = [side for step, side in _sides(outcome).items() if step in steps]
    cells = deposits.cells.get((key[0], sides[0]), _NO_CELLS) if sides else _NO_CELLS
    which = tuple(at for at, deposit in enumerate(deposits.each) if deposit.step in steps)
    volumes = np.array([deposits.each[at].volume_mm[cells] for at in which], dtype=np.float64)
    shape = (len(which), len(cells))
    return LowerBound(key, kind, least, steps, which, volumes.reshape(shape), deposits.areas_mm2[cells])

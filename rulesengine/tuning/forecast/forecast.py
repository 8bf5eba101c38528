"""What comes of spraying longer or shorter from each template: amounts and times add up, so that no analysis is needed.

On exposed surfaces that is exact but for the grain of the rays. What else the model knows of (pressure at edges, flow
and rinsing under parts) is left to analyses: where one finds less than was foretold, more is asked for from then on.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from boards.board import Side
from cleaning.verdicts.rules import INCOMPLETE_RINSE, IONIC_RESIDUE, MISSED, NOT_FLUSHED, RESIDUE_LEFT, UNDER_EXPOSED
from geometry.arrays import Scalars
from rulesengine.tuning.changes.expected_effect import arrives_nowhere, steps_for
from rulesengine.tuning.trial.deposits import Deposits
from rulesengine.tuning.trial.lower_bound import Key, Kind, Need, key_of
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import Spare, Want
from rulesengine.tuning.variables.design_variables import enabled_steps

_SAFE = 1.01
_MOST_SHORT = 0.8
_MOST_DOUBT = 1.25
"""No doubt grows by more at once: where a part has few cells, chance decides much of what the least wetted gets."""
_SPARE = 1.03
"""What the least wetted places are to get more than they need."""
_NO_CELLS = np.empty(0, dtype=np.int64)
_FLOWING = (NOT_FLUSHED, INCOMPLETE_RINSE, IONIC_RESIDUE)
_OF_AMOUNT = (UNDER_EXPOSED, RESIDUE_LEFT, *_FLOWING)


@dataclass(slots=True)
class Learnt:
    """What analyses taught of where forecasts promise too much."""

    doubts: dict[Key, float] = field(default_factory=dict[Key, float])
    """How many times as much is asked for."""
    means: dict[Key, tuple[float, frozenset[str]]] = field(default_factory=dict[Key, tuple[float, frozenset[str]]])
    """Mean amounts that are needed for what is no matter of the surface, and of which steps."""

    def forget_half(self) -> None:
        """Doubt less: forecasts from another outcome may err elsewhere."""
        self.doubts = {key: doubt**0.5 for key, doubt in self.doubts.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Forecast:
    """An outcome, taken apart so that others near it can be foretold."""

    outcome: Outcome
    deposits: Deposits
    idle_s: Mapping[str, float]
    """How long each step does not spray."""
    rest_s: float
    """Outside of all steps that spray."""
    needs: tuple[Need, ...]

    def durations(self, times: Scalars, often: Mapping[str, float]) -> dict[str, float]:
        """Foretell how long the steps take, s.

        Args:
            times: (deposits,) how many times as long each is sprayed.
            often: How many times as often a step is done; 1 if it is not named.
        """
        found = {step: idle * often.get(step, 1.0) for step, idle in self.idle_s.items()}
        for deposit, many in zip(self.deposits.each, times.tolist(), strict=True):
            found[deposit.step] += many * deposit.seconds
        return found

    def seconds(self, times: Scalars, often: Mapping[str, float]) -> float:
        """Foretell how long the program takes, s."""
        return self.rest_s + sum(self.durations(times, often).values())


def forecast(outcome: Outcome, learnt: Learnt, hopeless: frozenset[Key] = frozenset()) -> Forecast:
    """Take an outcome apart: what holds must go on to hold, and what is wanting must not lose.

    Args:
        outcome: Of an analysis.
        learnt: What others taught.
        hopeless: What stays wanting however long it is sprayed: no time is asked for it.
    """
    deposits = outcome.deposits
    idle = {step.made_by: step.seconds for step in outcome.steps}
    for deposit in deposits.each:
        idle[deposit.step] -= deposit.seconds
    rest = outcome.seconds - sum(step.seconds for step in outcome.steps)
    needs = [need for spare in outcome.spares for need in _of_spare(spare, outcome, learnt)]
    needs += [need for want in outcome.mendable if key_of(want) not in hopeless for need in _of_want(want, outcome)]
    needs += [_surface(key, "mean", steps, outcome, least) for key, (least, steps) in learnt.means.items()]
    return Forecast(outcome, deposits, idle, rest, tuple(needs))


def hopeless_of(outcome: Outcome, longest: Mapping[str, float]) -> frozenset[Key]:
    """Name what stays wanting however long it is sprayed: what is no matter of amounts, and what is out of reach.

    Args:
        outcome: What is wanting in it.
        longest: How many times as long each template may spray at most; 1 for those that are not named.
    """
    times = np.array([longest.get(deposit.template, 1.0) for deposit in outcome.deposits.each])
    found = {key_of(want) for want in outcome.wants if want.judgement.rule not in _OF_AMOUNT or arrives_nowhere(want)}
    for want in outcome.mendable:
        if want.judgement.rule == UNDER_EXPOSED and not arrives_nowhere(want):
            need = _lowest(want, outcome, 1.0 / (1.0 - want.deficit))
            found |= {need.key} if need.amount(times, {}) < need.least else set()
    # Where much of a surface is missed, amounts are not judged; they are as soon as a little less is missed.
    missed = [want for want in outcome.wants if want.judgement.rule == MISSED and want.judgement.verdict == "dirty"]
    return frozenset(found | {(want.component, UNDER_EXPOSED, want.judgement.stage) for want in missed})


def learn(learnt: Learnt, foretold: Forecast, found: Outcome, times: Scalars, often: Mapping[str, float]) -> bool:
    """Keep in mind what an analysis finds wanting though it was foretold to hold; ``False`` if there is no lesson."""
    durations = foretold.durations(times, often)
    before = {key_of(want): want.deficit for want in foretold.outcome.wants}
    needs = {need.key: need for need in foretold.needs}
    lessons = 0
    for want in found.wants:
        key = key_of(want)
        if want.deficit <= before.get(key, -1.0):
            continue
        need = needs.get(key)
        if need is not None and need.kind != "mean":
            doubt = learnt.doubts.get(key, 1.0)
            promised = need.amount(times, durations) * doubt / need.least
            missing = _SAFE * promised / (1.0 - min(want.deficit, _MOST_SHORT))
            learnt.doubts[key] = min(missing, _MOST_DOUBT * max(doubt, promised))
            lessons += 1
        else:
            lessons += _learn_mean(learnt, want, foretold, times)
    return lessons > 0


def _learn_mean(learnt: Learnt, want: Want, foretold: Forecast, times: Scalars) -> bool:
    """Ask for more than what was too little, and for less than what was enough."""
    steps = steps_for(want, foretold.outcome)
    need = _surface(key_of(want), "mean", steps, foretold.outcome, 0.0)
    had, gets = need.amount(np.ones(len(times)), {}), need.amount(times, {})
    if gets < had:
        learnt.means[need.key] = (had * gets) ** 0.5, steps
    return gets < had


def _of_spare(spare: Spare, outcome: Outcome, learnt: Learnt) -> Iterator[Need]:
    share = spare.needed * learnt.doubts.get(key_of(spare), 1.0)
    if spare.judgement.rule == RESIDUE_LEFT:
        yield _soaking(spare, outcome, share)
    elif spare.judgement.rule == UNDER_EXPOSED:
        yield _lowest(spare, outcome, _SPARE * share)


def _of_want(want: Want, outcome: Outcome) -> Iterator[Need]:
    """An amount that is too small is asked for in full; of what else is wanting, there shall be no less."""
    rule = want.judgement.rule
    if rule == RESIDUE_LEFT:
        yield _soaking(want, outcome, 1.0)
    elif rule == UNDER_EXPOSED and not arrives_nowhere(want):
        yield _lowest(want, outcome, 1.0 / (1.0 - want.deficit))
    elif rule in _FLOWING and want.deficit < 1.0:
        steps = steps_for(want, outcome)
        need = _surface(key_of(want), "mean", steps, outcome, 0.0)
        yield replace(need, least=need.amount(np.ones(len(outcome.deposits.each)), {}))


def _soaking(of: Spare | Want, outcome: Outcome, share: float) -> Need:
    steps = steps_for(of, outcome)
    return Need(key_of(of), "time", share * outcome.seconds_in(steps), steps, (), np.empty((0, 0)), np.empty(0))


def _lowest(of: Spare | Want, outcome: Outcome, share: float) -> Need:
    """What the least wetted places get; where the judgement names no step, its number tells which it adds up."""
    now = np.ones(len(outcome.deposits.each))
    value = of.judgement.numbers[0].value
    found = [_surface(key_of(of), "low", steps, outcome, 0.0) for steps in _groups(of, outcome)]
    amounts = [need.amount(now, {}) for need in found]
    nearest = min(range(len(found)), key=lambda at: abs(amounts[at] - value))
    return replace(found[nearest], least=share * amounts[nearest])


def _groups(of: Spare | Want, outcome: Outcome) -> list[frozenset[str]]:
    if of.judgement.stage:
        return [frozenset({of.judgement.stage})]
    sides = _sides(outcome)
    keys = dict.fromkeys((side, outcome.use_of(made_by)) for made_by, side in sides.items())
    groups = [frozenset(step for step in sides if (sides[step], outcome.use_of(step)) == key) for key in keys]
    return [group for group in groups if group]


def _sides(outcome: Outcome) -> dict[str, Side]:
    known = {deposit.step for deposit in outcome.deposits.each}
    sides: dict[str, Side] = {made_by: step.side for made_by, step in enabled_steps(outcome.recipe)}
    return {made_by: side for made_by, side in sides.items() if made_by in known}


def _surface(key: Key, kind: Kind, steps: frozenset[str], outcome: Outcome, least: float) -> Need:
    """What some steps, all on one side, leave on the surface of a component."""
    deposits = outcome.deposits
    sides: list[Side] = [side for step, side in _sides(outcome).items() if step in steps]
    cells = deposits.cells.get((key[0], sides[0]), _NO_CELLS) if sides else _NO_CELLS
    which = tuple(at for at, deposit in enumerate(deposits.each) if deposit.step in steps)
    volumes = np.array([deposits.each[at].volume_mm[cells] for at in which], dtype=np.float64)
    return Need(key, kind, least, steps, which, volumes.reshape(len(which), len(cells)), deposits.areas_mm2[cells])

"""Second stage of tuning: all speeds at once by linear programs on forecasts, confirmed by analyses."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rulesengine.tuning.changes.expected_effect import Change
from rulesengine.tuning.changes.new_paths import new_paths
from rulesengine.tuning.forecast.forecast import Corrections, Forecast, correct, forecast
from rulesengine.tuning.forecast.minimum_times import Option, shortening_options
from rulesengine.tuning.forecast.speed_curves import SpeedCurve, plan_speeds, speed_curves, tunable_speeds
from rulesengine.tuning.search.acceptance import Acceptance
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import BOARD, UnmetRequirement
from rulesengine.tuning.trial.trial_runner import TuningContext

_BY_PATH = 3.0
"""A path that is added has to save so many times as much as is worth an analysis."""
_STAGE = "speeds"
_MOST_FAILURES = 3
"""How often an option may fail before it is left."""
_MOST_DETOURS = 2
"""How often speeds are adapted to another recipe before it is left."""
_SCARCE_DEFICIT = 0.5
"""Of a surface for which a path is added."""


@dataclass(slots=True)
class _Search:
    """Context, acceptance, and what failed trials taught."""

    context: TuningContext
    acceptance: Acceptance
    corrections: Corrections = field(default_factory=Corrections)
    failures: dict[str, int] = field(default_factory=dict[str, int])
    """By name of an option or description of a path."""


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """An outcome with its forecast."""

    predicted: Forecast
    curves: Mapping[str, SpeedCurve]
    options: Sequence[Option]
    """That may be tried, the shortest first."""
    reference: Outcome
    """That has to be shortened: the same, unless the outcome is a detour."""
    least_saved: float
    """Share of the reference's time below which a saving is not tried for."""

    @property
    def now(self) -> Outcome:
        return self.predicted.outcome

    @property
    def best(self) -> Option | None:
        """The option that saves most, if it is enough."""
        found = self.options[0] if self.options else None
        return found if found is not None and self.saving > self.least_saved else None

    @property
    def saving(self) -> float:
        """Share of the reference's time that the best option is predicted to save."""
        return max(0.0, 1.0 - self.options[0].found.seconds / self.reference.seconds) if self.options else 0.0


def shorten_by_linear_program(context: TuningContext, acceptance: Acceptance) -> Outcome:
    """Shorten a recipe as long as it is accepted, and an option saves what is worth an analysis.

    All speeds change at once, with one whole number or one path less. Where a path more would save more than it takes,
    because what it sprays is what the others are so long for, it is added first.
    """
    search = _Search(context, acceptance)
    now, begun = acceptance.reference, context.runner.used
    context.ended.pop(_STAGE, None)
    while context.runner.left > 0:
        context.runner.estimate.shortening(context.runner.used - begun)
        state = _predict(search, now)
        path = _best_path(search, state)
        if path is not None:
            after, what = _try_path(search, now, path)
        elif state.best is not None:
            after, what = _try_option(search, state, state.best)
        else:
            context.ended[_STAGE] = (
                f"Other speeds, numbers and paths are predicted to save {state.saving:.1%} of the time at most; an "
                f"analysis is worth {state.least_saved:.1%}."
            )
            break
        if what:
            context.accept(what, now, after)
        now = after
    return now


def shorten_from(context: TuningContext, acceptance: Acceptance, begin: Outcome) -> tuple[Outcome, Sequence[str]]:
    """Change the speeds of another recipe, and nothing else, so that it is accepted and saves what is worth it.

    Returns:
        The outcome and what changed; the reference and nothing where that is not predicted, or fails.
    """
    search = _Search(context, acceptance)
    for _ in range(_MOST_DETOURS):
        state = _predict(search, begin, acceptance.reference)
        state = replace(state, options=[each for each in state.options if not each.name])
        if state.best is None or context.runner.left <= 0:
            break
        after, what = _try_option(search, state, state.best)
        if what:
            return after, what
    return acceptance.reference, []


def _predict(search: _Search, now: Outcome, reference: Outcome | None = None) -> _State:
    context = search.context
    kept = now if reference is None else reference  # of a detour, what it lost has to be met again
    owed = frozenset(each.key for each in now.unmet) - frozenset(each.key for each in kept.unmet)
    predicted = forecast(now, search.corrections, search.acceptance.unattainable, owed)
    curves = speed_curves(context.runner, now.text, tunable_speeds(context, now))
    options = shortening_options(context, predicted, curves)
    options = [each for each in options if search.failures.get(each.name, 0) < _MOST_FAILURES]
    return _State(predicted, curves, options, reference or now, context.request.worth.saving)


def _try_option(search: _Search, state: _State, option: Option) -> tuple[Outcome, Sequence[str]]:
    """Analyse an option; the outcome and what changed, or the present one and nothing."""
    now, used = state.now, search.context.runner.used
    after, option = _analysed(search, state, option)
    if after is not None and search.acceptance.accepts(after):
        search.corrections.relax()
        search.failures = {name: count - 1 for name, count in search.failures.items()}
        return after, option.what
    corrected = False
    if after is not None and search.context.runner.used > used:  # an outcome from earlier teaches no more
        corrected = correct(search.corrections, state.predicted, after, option.found.times, option.scheme.repeats)
    failures = 1 if corrected else _MOST_FAILURES
    search.failures[option.name] = search.failures.get(option.name, 0) + failures
    return now, []


def _analysed(search: _Search, state: _State, option: Option) -> tuple[Outcome | None, Option]:
    """Analyse an option if it makes the program shorter and needs no more liquid; return it with its planned times."""
    runner, now = search.context.runner, state.now
    deposits = now.deposits.each
    required = {
        (each.step, each.template): float(times) * each.seconds
        for each, times in zip(deposits, option.found.times, strict=True)
    }
    plan = plan_speeds(runner, (now.text, option.edits), state.curves, required, option.found.factors)
    if plan is None or plan.candidate.litres > state.reference.litres:
        return None, option
    if plan.candidate.seconds > (1.0 - state.least_saved / 2) * state.reference.seconds:
        return None, option
    times = np.array([plan.times.get((each.step, each.template), 0.0) / max(each.seconds, 1e-9) for each in deposits])
    found = replace(option.found, times=times, seconds=plan.candidate.seconds)
    return runner.outcome(plan.candidate.text), replace(option, what=(*option.what, *plan.what), found=found)


def _best_path(search: _Search, state: _State) -> Change | None:
    """Find the path whose surfaces make the program most of what it is longer, if it would save enough by itself."""
    runner, now = search.context.runner, state.now
    seconds = now.seconds if state.best is None else state.best.found.seconds
    best: tuple[float, Change] | None = None
    for unmet, rest in _without_surfaces(state.predicted):
        paths = [
            each
            for each in new_paths(now, unmet)
            if search.context.request.allowed.permits(each.kind, each.edits) and not search.failures.get(each.what)
        ]
        without = shortening_options(search.context, rest, state.curves) if paths else []
        for path in paths if without else ():
            candidate = runner.candidate(now.text, path.edits)
            if candidate is not None:
                saved = seconds - without[0].found.seconds - (candidate.seconds - now.seconds)
                if saved > _BY_PATH * state.least_saved * now.seconds and (best is None or saved > best[0]):
                    best = saved, path
    return None if best is None else best[1]


def _without_surfaces(predicted: Forecast) -> Iterator[tuple[list[UnmetRequirement], Forecast]]:
    """The surfaces of the board, then those of the parts, as if they were not met; and the forecast without them."""
    for of_board in (True, False):
        keys = {bound.key for bound in predicted.bounds if bound.kind == "low" and (bound.key[0] == BOARD) == of_board}
        unmet = [each for each in predicted.outcome.unmet if each.key in keys]
        unmet += [
            UnmetRequirement(each.component, each.judgement, _SCARCE_DEFICIT)
            for each in predicted.outcome.met
            if each.key in keys
        ]
        yield unmet, replace(predicted, bounds=tuple(bound for bound in predicted.bounds if bound.key not in keys))


def _try_path(search: _Search, now: Outcome, path: Change) -> tuple[Outcome, Sequence[str]]:
    """Add a path, and shorten until that saves more than it takes; else leave it."""
    runner = search.context.runner
    search.failures[path.what] = 1
    candidate = runner.candidate(now.text, path.edits)
    longer = None if candidate is None else runner.outcome(candidate.text)
    if longer is None or not search.acceptance.accepts(longer):
        return now, []
    fresh = _Search(search.context, search.acceptance)
    after, what = longer, [path.what]
    while runner.left > 0 and after.seconds >= now.seconds:
        state = _predict(fresh, after)
        if state.best is None or state.best.found.seconds >= now.seconds:
            return now, []
        after, made = _try_option(fresh, state, state.best)
        what += made
    if after.seconds >= now.seconds:
        return now, []
    search.corrections, search.failures = fresh.corrections, fresh.failures | {path.what: 1}
    return after, what

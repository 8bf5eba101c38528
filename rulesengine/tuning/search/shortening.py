"""Moves that shorten a recipe: all speeds at once by linear programs on forecasts.

All speeds change together, with one whole number or one path less. Where a path more would save more than it takes,
because what it sprays is what the others are so long for, it is added first.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from rulesengine.tuning.changes.candidate_changes import Change, new_paths
from rulesengine.tuning.forecast.forecast import Corrections, Forecast, correct, forecast
from rulesengine.tuning.forecast.minimum_times import Option, shortening_options
from rulesengine.tuning.forecast.speed_curves import plan_speeds
from rulesengine.tuning.search.moves import Move, TuningContext
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import BOARD, UnmetRequirement
from rulesengine.tuning.trial.trial_runner import Candidate

_KIND = "speeds"
_BY_PATH = 3.0
"""A path that is added has to save so many times as much as is worth an analysis."""
_MOST_FAILURES = 3
"""How often an option may fail before it is left."""
_SCARCE_DEFICIT = 0.5
"""Of a surface for which a path is added."""


@dataclass(slots=True)
class Shortening:
    """What failed trials taught."""

    context: TuningContext
    corrections: Corrections = field(default_factory=Corrections)
    failures: dict[str, int] = field(default_factory=dict[str, int])
    """By name of an option or description of a path."""
    begun: int = 0
    """Analyses before it began."""
    exhausted: Outcome | None = None
    """Which nothing shortens any more."""

    def propose(self, now: Outcome) -> Move | None:
        """The move that is forecast to save most; none where it saves less than an analysis is worth."""
        if now is self.exhausted:
            return None
        self.context.runner.estimate.shortening(self.context.runner.used - self.begun)
        self.context.ended.pop(_KIND, None)
        predicted = self._predict(now)
        options = shortening_options(predicted, self.context.curves(now), self.context.reductions(now))
        options = [each for each in options if self.failures.get(each.name, 0) < _MOST_FAILURES]
        move = self._path_added(predicted, options) or self._by_options(predicted, options, now)
        if move is None:
            self.exhausted = now
            saving = max(0.0, 1.0 - options[0].found.seconds / now.seconds) if options else 0.0
            self.context.ended[_KIND] = (
                f"Other speeds, numbers and paths are predicted to save {saving:.1%} of the time at most; an "
                f"analysis is worth {self.context.request.worth.saving:.1%}."
            )
        return move

    def adapt(self, landed: Outcome) -> Move | None:
        """The speeds of another recipe, and nothing else, that make it shorter than the best and as clean."""
        predicted = self._predict(landed)
        options = shortening_options(predicted, self.context.curves(landed), {})
        return self._by_options(predicted, options, self.context.best)

    def _predict(self, now: Outcome) -> Forecast:
        best = self.context.best
        owed = frozenset(each.key for each in now.unmet) - frozenset(each.key for each in best.unmet)
        return forecast(now, self.corrections, self.context.acceptance.unattainable, owed)

    def _by_options(self, predicted: Forecast, options: list[Option], reference: Outcome) -> Move | None:
        """Speeds for the shortest option that is shorter as planned, too, and needs no more liquid."""
        now, runner = predicted.outcome, self.context.runner
        deposits, least = now.deposits.each, self.context.request.worth.saving
        for option in options:
            if 1.0 - option.found.seconds / reference.seconds <= least:
                break
            required = {
                (each.step, each.template): float(times) * each.seconds
                for each, times in zip(deposits, option.found.times, strict=True)
            }
            edited = now.text, option.edits
            plan = plan_speeds(runner, edited, self.context.curves(now), required, option.found.factors)
            most_s = (1.0 - least / 2) * reference.seconds
            if plan is not None and plan.candidate.litres <= reference.litres and plan.candidate.seconds <= most_s:
                times = np.array(
                    [plan.times.get((each.step, each.template), 0.0) / max(each.seconds, 1e-9) for each in deposits]
                )
                planned = replace(option, found=replace(option.found, times=times))
                learn = partial(self._learn_option, predicted, planned)
                return Move((*option.what, *plan.what), plan.candidate, learn)
            self.failures[option.name] = _MOST_FAILURES
        return None

    def _learn_option(self, predicted: Forecast, option: Option, after: Outcome | None, accepted: bool) -> None:
        if accepted:
            self.corrections.relax()
            self.failures = {name: count - 1 for name, count in self.failures.items()}
            return
        corrected = after is not None and correct(
            self.corrections, predicted, after, option.found.times, option.scheme.repeats
        )
        self.failures[option.name] = self.failures.get(option.name, 0) + (1 if corrected else _MOST_FAILURES)

    def _path_added(self, predicted: Forecast, options: list[Option]) -> Move | None:
        """The path whose surfaces make the program most of what it is longer, if it would save enough by itself."""
        context, now = self.context, predicted.outcome
        seconds = min([now.seconds, *(each.found.seconds for each in options[:1])])
        best: tuple[float, Change, Candidate] | None = None
        for unmet, rest in _without_surfaces(predicted):
            paths = [
                each
                for each in new_paths(now, unmet)
                if context.request.allowed.permits(each.kind, each.edits) and not self.failures.get(each.what)
            ]
            without = shortening_options(rest, context.curves(now), context.reductions(now)) if paths else []
            for path in paths if without else ():
                candidate = context.runner.candidate(now.text, path.edits)
                if candidate is not None:
                    saved = seconds - without[0].found.seconds - (candidate.seconds - now.seconds)
                    least = _BY_PATH * context.request.worth.saving * now.seconds
                    if saved > least and (best is None or saved > best[0]):
                        best = saved, path, candidate
        if best is None:
            return None
        self.failures[best[1].what] = 1
        return Move((best[1].what,), best[2], _learn_nothing, by_speeds=True)


def _learn_nothing(_after: Outcome | None, _accepted: bool) -> None:
    """A path that was tried once is left."""


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

"""Moves that shorten a recipe: all speeds at once by linear programs on forecasts.

All speeds change together, with one whole number or one path less. Where a path more would save more than it takes,
because what it sprays is what the others are so long for, it is added first.

Where small changes no longer shorten it, moves jump to other paths, heights, tilts and pressures. How much lands then
no forecast knows. So a jump is analysed as it is, and from that outcome the linear programs forecast what speeds it
needs: it is taken if the whole is shorter.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from rulesengine.tuning.changes.candidate_changes import Change, new_paths, replaced_paths, variables_of
from rulesengine.tuning.forecast.forecast import Corrections, Forecast, correct, forecast
from rulesengine.tuning.forecast.minimum_times import Option, plan_speeds, shortening_options
from rulesengine.tuning.search.moves import Move, TuningContext
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import BOARD, UnmetRequirement
from rulesengine.tuning.trial.trial_runner import Candidate
from rulesengine.tuning.variables import ChangeKind, DesignVariable, Edits

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


_JUMPS = "jumps"
_NEARER = 0.7
"""Of a height: the ring of a hollow cone becomes narrower by as much, and hits a half harder."""
_TILT_DEG = 15.0
_VALUES: dict[ChangeKind, Callable[[DesignVariable, int], float]] = {
    "heights": lambda each, way: each.value * _NEARER**way,
    "tilts": lambda each, way: each.value - way * _TILT_DEG,
    "pressure": lambda each, way: (each.value * each.upper) ** 0.5 if way > 0 else each.value,
}
"""Values to jump to: 1 nearer, flatter, or with more pressure, and -1 back."""
_MOST_VAIN = 2
"""Jumps in a row that save nothing before those of their kind end."""
_LEAST_SHARE = 0.05
"""Of the spraying time that a template takes: what takes less cannot save much."""
_MOST_LONGER = 1.5
"""Times the program that a jump may take before its speeds are adapted."""


@dataclass(frozen=True, slots=True)
class Jump:
    """Another path, or other values of one or several variables at once."""

    name: str
    """What changes, the same from one recipe to the next."""
    way: int
    """1 or -1, and 0 where there is no way back."""
    what: tuple[str, ...]
    edits: Edits


@dataclass(slots=True)
class Jumping:
    """Which jumps of one kind were tried."""

    context: TuningContext
    jumps: Callable[[TuningContext, Outcome], Iterator[Jump]]
    tried: set[tuple[str, int]] = field(default_factory=set[tuple[str, int]])
    """By name and way."""
    failures: int = 0
    """In a row."""

    def propose(self, now: Outcome) -> Move | None:
        """The next jump, until several in a row save nothing."""
        self.context.ended.pop(_JUMPS, None)
        for jump in self.jumps(self.context, now) if self.failures < _MOST_VAIN else ():
            if (jump.name, jump.way) not in self.tried:
                self.tried.add((jump.name, jump.way))
                candidate = self.context.runner.candidate(now.text, jump.edits)
                if candidate is not None and candidate.seconds <= _MOST_LONGER * now.seconds:
                    return Move(jump.what, candidate, partial(self._learn, jump), by_speeds=True)
        least = self.context.request.worth.saving
        self.context.ended[_JUMPS] = f"No other path, height, tilt or pressure that was tried saves {least:.1%}."
        return None

    def _learn(self, jump: Jump, after: Outcome | None, accepted: bool) -> None:
        if accepted:
            self.tried = (self.tried - {(jump.name, jump.way)}) | {(jump.name, -jump.way)}
        self.failures = 0 if accepted else self.failures + (after is not None)


def jumps_of_paths(context: TuningContext, outcome: Outcome) -> Iterator[Jump]:
    """Jumps to another path in the place of one, if the program becomes shorter by it; the shortest first."""
    found: list[tuple[float, Jump]] = []
    for template, share in _shares(outcome).items():
        for change in replaced_paths(outcome, template) if share >= _LEAST_SHARE else ():
            candidate = context.runner.candidate(outcome.text, change.edits)
            if (
                candidate is not None
                and candidate.seconds < outcome.seconds
                and context.request.allowed.permits(change.kind, change.edits)
            ):
                found.append((candidate.seconds, Jump(change.what, 0, (change.what,), change.edits)))
    yield from (jump for _, jump in sorted(found, key=lambda each: each[0]))


def jumps_of_values(context: TuningContext, outcome: Outcome) -> Iterator[Jump]:
    """Jumps that are allowed: of all heights together, of pressures, then template by template, the longest first."""
    drying = frozenset(step.made_by for step in outcome.steps if step.use == "dry")
    variables = [
        each
        for each in variables_of(outcome)
        if each.kind in _VALUES
        and not each.component_class
        and not drying & frozenset(each.steps)
        and context.request.allowed.permits(each.kind, each.edit(each.value))
    ]
    shares = _shares(outcome)
    longest = sorted((name for name, share in shares.items() if share >= _LEAST_SHARE), key=lambda name: -shares[name])
    heights = [each for each in variables if each.kind == "heights" and each.template in shares]
    groups = [("all heights", heights)] if len(heights) > 1 else []
    groups += [(str(each.path), [each]) for each in variables if each.kind == "pressure"]
    groups += [(str(each.path), [each]) for name in longest for each in variables if each.template == name]
    for name, group in groups:
        for way in (1, -1):
            values = [(each, each.rounded(_VALUES[each.kind](each, way))) for each in group]
            changed = [(each, value) for each, value in values if value != each.value]
            if changed:
                what = tuple(each.describe(value) for each, value in changed)
                yield Jump(name, way, what, tuple(edit for each, value in changed for edit in each.edit(value)))


def _shares(outcome: Outcome) -> dict[str, float]:
    """Share of the spraying time of each template, without drying."""
    seconds: dict[str, float] = {}
    for each in outcome.deposits.each:
        if outcome.use_of(each.step) != "dry":
            seconds[each.template] = seconds.get(each.template, 0.0) + each.seconds
    total = sum(seconds.values())
    return {template: each / total for template, each in seconds.items()} if total > 0 else {}

"""Moves of the search, their acceptance, and the tuning that goes on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from cleaning.verdicts.rules import VERDICTS
from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.changes.reductions import Reduction, reductions
from rulesengine.tuning.forecast.forecast import unattainable
from rulesengine.tuning.forecast.minimum_times import SpeedCurve, speed_curves, tunable_speeds
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import AcceptedChange, Cost, TuningRequest
from rulesengine.tuning.trial.requirements import Key, UnmetRequirement, total_shortfall
from rulesengine.tuning.trial.trial_runner import Candidate, TrialRunner

_LEAST_GAIN = 0.005
"""Share of the shortfall that is a gain."""
Observer: TypeAlias = Callable[["TuningContext"], None]
"""Receives a tuning that goes on, whenever its best recipe is another one."""


@dataclass(frozen=True, slots=True, eq=False)
class Acceptance:
    """Acceptance test against a reference outcome."""

    request: TuningRequest
    reference: Outcome
    unattainable: frozenset[Key]
    """Requirements that no spraying time meets: they may lose something, but not their verdict."""

    def accepts(self, after: Outcome) -> bool:
        """Whether an outcome is nearer to the limits; or as near, and cleaner for its price or shorter and as clean."""
        limits, before = self.request.limits, self.reference
        over, allowed = (limits.excess(each) for each in (after, before))
        if over != allowed:
            return over < allowed
        if before.shortfall - after.shortfall > _LEAST_GAIN * before.shortfall:
            return self.price_s(after) <= self.request.worth.requirement_s
        return after.seconds < before.seconds and after.litres <= before.litres and self.keeps(after)

    def price_s(self, after: Outcome) -> float:
        """Seconds, liquid with them, that an outcome costs for each requirement that it meets besides."""
        gained = self.reference.shortfall - after.shortfall
        return self.request.worth.added_s(self.reference, after) / gained

    def saves(self, after: Cost) -> bool:
        """Whether time and liquid are saved, as much as is worth an analysis."""
        worth = self.request.worth
        return worth.saved(self.reference, after) >= worth.saving and after.litres <= self.reference.litres

    def keeps(self, after: Outcome) -> bool:
        """Whether no more requirements are unmet than in the reference, in number and in all."""
        before, now = self._worst_verdicts(self.reference), self._worst_verdicts(after)
        if any(rank < before.get(name, rank) for name, rank in now.items()):
            return False
        unmet, reference = self._attainable(after), self._attainable(self.reference)
        return len(unmet) <= len(reference) and total_shortfall(unmet) <= total_shortfall(reference)

    def _worst_verdicts(self, outcome: Outcome) -> dict[str, int]:
        """Rank of the worst verdict on what is unattainable of each component; 0 is the worst."""
        found: dict[str, int] = {}
        for unmet in outcome.unmet:
            if unmet.key in self.unattainable:
                rank = VERDICTS.index(unmet.judgement.verdict)
                found[unmet.component] = min(rank, found.get(unmet.component, rank))
        return found

    def _attainable(self, outcome: Outcome) -> tuple[UnmetRequirement, ...]:
        return tuple(unmet for unmet in outcome.unmet if unmet.key not in self.unattainable)


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """A candidate change of a recipe with its forecast, about to be analysed."""

    what: tuple[str, ...]
    """Values from and to."""
    candidate: Candidate
    learn: Callable[[Outcome | None, bool], None]
    """Receives the outcome of its analysis, and whether that was accepted."""
    by_speeds: bool = False
    """Whether it is a detour: no forecast knows what it does, and other speeds may make of it what is accepted."""


class TuningContext:
    """A tuning that goes on: the runner of trials, the request, the best recipe, and the changes that led to it."""

    def __init__(self, runner: TrialRunner, request: TuningRequest, first: Outcome, observer: Observer) -> None:
        """Begin with the outcome of the initial recipe."""
        self.runner, self.request, self.first = runner, request, first
        self.best = first
        self.changes: list[AcceptedChange] = []
        self.ended: dict[str, str] = {}
        """Why each kind of moves ended, by kind."""
        self._initial_values = {variable.path: variable.value for variable in reversed(variables_of(first))}
        self._curves: dict[str, dict[str, SpeedCurve]] = {}
        self._observer = observer
        self._acceptance: Acceptance | None = None
        self._observe()

    @property
    def acceptance(self) -> Acceptance:
        """Acceptance test against the best recipe."""
        if self._acceptance is None:
            longest = {name: curve.bounds[1] for name, curve in self.curves(self.best).items()}
            self._acceptance = Acceptance(self.request, self.best, unattainable(self.best, longest))
        return self._acceptance

    def reductions(self, of: Outcome) -> dict[str, Reduction]:
        """Ways to save time that are allowed, by name."""
        return reductions(of, self._initial_values, self.request.allowed)

    def curves(self, of: Outcome) -> Mapping[str, SpeedCurve]:
        """Spraying times of the templates of a recipe over those of its speeds that may change."""
        if of.text not in self._curves:
            self._curves = {of.text: speed_curves(self.runner, of.text, tunable_speeds(self.request.allowed, of))}
        return self._curves[of.text]

    def accept(self, what: Sequence[str], after: Outcome) -> None:
        """Take a better recipe in the place of the best one."""
        self.changes.append(AcceptedChange(tuple(what), self.best.figures, after.figures))
        self.best = after
        self._observe()

    def _observe(self) -> None:
        self._acceptance = None
        self.runner.best = self.best.figures
        self._observer(self)

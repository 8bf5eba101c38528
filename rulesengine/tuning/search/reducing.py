"""Moves that reduce one number: to keep the limits, or as far as the slack of the requirements suggests."""

from dataclasses import dataclass, field
from functools import partial

from rulesengine.tuning.changes.reductions import Reduction, acceptable_share
from rulesengine.tuning.search.moves import Move, TuningContext
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.trial_runner import Candidate

_LEAST_SAVING = 0.1
"""Of what is worth an analysis: pauses and numbers by class are many, and each saves a little."""
_MOST_FAILURES = 3
"""How often a reduction may fail, half as far each time, before it is left."""


@dataclass(slots=True)
class Reducing:
    """Reductions that failed."""

    context: TuningContext
    failures: dict[str, int] = field(default_factory=dict[str, int])

    def relieve(self, now: Outcome) -> Move | None:
        """The reduction that leads nearest to the limits; of several that keep them that with the most slack."""
        return self.propose(now) if self.context.request.limits.excess(now) else None

    def propose(self, now: Outcome) -> Move | None:
        """The reduction that saves most, of those that no linear program knows; beyond the limits as ``relieve``."""
        limits = self.context.request.limits
        over = limits.excess(now)
        least_s = _LEAST_SAVING * self.context.request.worth.saving * now.seconds
        best: tuple[tuple[float, float], Move] | None = None
        for name, each in self.context.reductions(now).items():
            failures = self.failures.get(name, 0)
            whole = self._candidate(now, each, each.end)
            if whole is None or failures >= _MOST_FAILURES or not (over or each.is_unknown):
                continue
            saved = now.seconds - whole.seconds
            share = acceptable_share(now, each, saved)
            value = self._just_within(now, each) if over else each.value_at(share * 0.5**failures)
            candidate = None if value is None else self._candidate(now, each, value)
            if value is None or candidate is None:
                continue
            if over:
                taken = (now.seconds - candidate.seconds) / saved if saved > 0 else 1.0
                rank = limits.excess(candidate), round(taken - share, 6)
                helps = rank[0] < over
            else:
                rank = 0.0, round(candidate.seconds, 3)
                helps = now.seconds - candidate.seconds > least_s and candidate.litres <= now.litres
            if helps and (best is None or rank < best[0]):
                best = rank, Move((each.change_to(value)[0],), candidate, partial(self._learn, name))
        return None if best is None else best[1]

    def _learn(self, name: str, _after: Outcome | None, accepted: bool) -> None:
        if not accepted:
            self.failures[name] = self.failures.get(name, 0) + 1

    def _candidate(self, now: Outcome, reduction: Reduction, value: float) -> Candidate | None:
        return self.context.runner.candidate(now.text, reduction.change_to(value)[1])

    def _just_within(self, now: Outcome, reduction: Reduction) -> float:
        """Value that just keeps the limits, found by planning alone; the end where even that does not keep them."""
        good, bad, value = reduction.end, reduction.begin, reduction.end
        while value is not None:
            candidate = self._candidate(now, reduction, value)
            if candidate is not None and self.context.request.limits.excess(candidate) == 0:
                good = value
            elif value == reduction.end:
                break
            else:
                bad = value
            value = reduction.bisect(good, bad)
        return good

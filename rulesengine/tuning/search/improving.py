"""Moves that meet more requirements: the changes with the most expected gain for their cost, until every one is met.

And moves that reduce one number: to keep the limits, or as far as the slack of the requirements suggests.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from rulesengine.tuning.changes.candidate_changes import Change, candidate_changes
from rulesengine.tuning.changes.reductions import Reduction, acceptable_share
from rulesengine.tuning.search.moves import Move, TuningContext
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import Key
from rulesengine.tuning.trial.trial_runner import Candidate

_KIND = "requirements"
_MOST_PLANNED = 12
"""Changes of the highest expected gain that are planned, which is quick, to know what they cost."""
_MOST_FAILURES = 7
"""Moves without success in a row before there are no more."""
_COST_SHARE = 0.05
"""Of the time that the program takes now: what is added to the cost of a change, so that steps do not become tiny,"""
_COST_S = 20.0
"""and neither where the program hardly takes any time yet."""
_NOT_IMPROVED = 0.98
"""Share of its deficit above which a requirement counts as not improved."""
PRIORITY_DECAY = 0.6
"""Of a requirement that a change failed to improve."""
CONFIDENCE_DECAY = 0.25
"""Least factor on the confidence in changes of a group after one of them gained less than expected."""


@dataclass(slots=True)
class Improvement:
    """How far changes and requirements met expectations."""

    context: TuningContext
    confidence: dict[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    """By group of changes."""
    priority: dict[Key, float] = field(default_factory=dict[Key, float])
    """By requirement."""
    last: Outcome | None = None
    """Of which the changes were tried."""
    tried: set[str] = field(default_factory=set[str])
    """Texts of its changes."""
    too_dear: tuple[float, str] | None = None
    """Of the changes that were left because they cost more than they are worth, the cheapest: seconds for one
    requirement, and what it was."""

    def propose(self, now: Outcome) -> Move | None:
        """The changes of the highest expected gain for their cost: of washing and rinsing at once, or one."""
        context, ranked = self.context, list[tuple[Change, Candidate]]()
        context.ended.pop(_KIND, None)
        if now is not self.last:
            self.last, self.tried, self.too_dear = now, set(), None
        if now.attainable and len(self.tried) < _MOST_FAILURES:
            shortfalls = context.first.shortfall, now.shortfall
            context.runner.estimate.improving(shortfalls, context.runner.used, context.runner.left)
            ranked = self._ranked(now)
        bundle, taken = list[Change](), set[str]()
        for change, _ in ranked:  # the best change, and the best of other uses: washing and rinsing are changed at once
            uses = {str(now.use_of(step)) for step in change.steps}
            if uses and not uses & taken:
                bundle.append(change)
                taken |= uses
        together = self._within_limits(now, bundle) if len(bundle) > 1 else None
        moves = [(bundle, together), *(([change], candidate) for change, candidate in ranked)]
        for changes, candidate in moves:
            if candidate is not None and candidate.text not in self.tried:
                self.tried.add(candidate.text)
                return Move(tuple(each.what for each in changes), candidate, partial(self._learn, now, changes))
        if self.too_dear is not None:
            price, what = self.too_dear
            context.ended[_KIND] = (
                f"What is not met yet costs more than it is worth: {price:.0f} s for one more requirement by {what}, "
                f"and {context.request.worth.requirement_s:g} s are allowed."
            )
        elif now.attainable:
            context.ended[_KIND] = "Of the allowed changes none improves what is not met yet."
        return None

    def _learn(self, now: Outcome, changes: Sequence[Change], after: Outcome | None, accepted: bool) -> None:
        """Lower the confidence in changes that gain less than expected, the priority of what they do not improve."""
        gained = 0.0 if after is None else now.shortfall - after.shortfall
        share = gained / max(sum(change.most_gain for change in changes), 1e-9)
        if len(changes) == 1 or share > 0:  # of several at once, none loses confidence for long
            for change in changes:
                factor = min(1.0, max(CONFIDENCE_DECAY, share))
                self.confidence[change.group] = factor * self.confidence.get(change.group, 1.0)
        if accepted:
            return
        if after is not None and gained > 0:
            price = self.context.acceptance.price_s(after)
            if price > self.context.request.worth.requirement_s and (self.too_dear is None or price < self.too_dear[0]):
                self.too_dear = price, " and ".join(change.what for change in changes)
        left = {} if after is None else {unmet.key: unmet.deficit for unmet in after.unmet}
        targets = frozenset(key for change in changes for key in change.targets)
        for unmet in now.attainable:
            if unmet.key in targets and (after is None or left.get(unmet.key, 0.0) > _NOT_IMPROVED * unmet.deficit):
                self.priority[unmet.key] = PRIORITY_DECAY * self.priority.get(unmet.key, 1.0)

    def _ranked(self, now: Outcome) -> list[tuple[Change, Candidate]]:
        """Plan the most promising changes, leave out what breaks a limit, and sort by gain for the cost."""

        def confidence(change: Change) -> float:
            return self.confidence.get(change.group, 1.0)

        unmet = [replace(each, priority=self.priority.get(each.key, 1.0)) for each in now.attainable]
        promising = sorted(
            candidate_changes(now, unmet, self.context.request.allowed),
            key=lambda change: -round(confidence(change) * change.most_gain, 6),
        )
        ranked: list[tuple[float, tuple[Change, Candidate]]] = []
        for change in promising[:_MOST_PLANNED]:
            candidate = self._within_limits(now, [change])
            if candidate is not None:
                longer = candidate.seconds - now.seconds
                cost = max(longer, 0.0) + _COST_SHARE * now.seconds + _COST_S
                gain = round(confidence(change) * change.gain_in(longer) / cost, 9)
                ranked.append((gain, (change, candidate)))
        return [each for _, each in sorted(ranked, key=lambda pair: -pair[0])]

    def _within_limits(self, now: Outcome, changes: Sequence[Change]) -> Candidate | None:
        """Plan changes; ``None`` where that cannot be done or leads farther beyond the limits."""
        edits = tuple(edit for change in changes for edit in change.edits)
        candidate = self.context.runner.candidate(now.text, edits)
        excess = self.context.request.limits.excess
        if candidate is None or excess(candidate) > excess(now):
            return None
        return candidate


_LEAST_SAVING = 0.1
"""Of what is worth an analysis: pauses and numbers by class are many, and each saves a little."""
_MOST_REDUCED = 3
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
            if whole is None or failures >= _MOST_REDUCED or not (over or each.is_unknown):
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

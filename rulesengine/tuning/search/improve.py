"""First stage of tuning: the change with the most expected gain for its time, until every requirement is met."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from rulesengine.tuning.changes.candidate_changes import candidate_changes
from rulesengine.tuning.changes.expected_effect import Change
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import Key
from rulesengine.tuning.trial.trial_runner import Candidate, TuningContext

_STAGE = "requirements"
_MOST_PLANNED = 12
"""Changes of the highest expected gain that are planned, which is quick, to know what they cost."""
_MOST_TRIED = 6
"""Changes that are analysed without success before the stage ends."""
_COST_SHARE = 0.05
"""Of the time that the program takes now: what is added to the cost of a change, so that steps do not become tiny,"""
_COST_S = 20.0
"""and neither where the program hardly takes any time yet."""
_LEAST_GAIN = 0.005
"""Share of the shortfall that a change must remove."""
_NOT_IMPROVED = 0.98
"""Share of its deficit above which a requirement counts as not improved."""
PRIORITY_DECAY = 0.6
"""Of a requirement that a change failed to improve."""
CONFIDENCE_DECAY = 0.25
"""Least factor on the confidence in changes of a group after one of them gained less than expected."""


@dataclass(slots=True)
class Improvement:
    """State of the stage: how far changes and requirements met expectations."""

    context: TuningContext
    confidence: dict[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    """By group of changes."""
    priority: dict[Key, float] = field(default_factory=dict[Key, float])
    """By requirement."""
    too_dear: tuple[float, str] | None = None
    """Of the changes that were left because they cost more than they are worth, the cheapest: seconds for one
    requirement, and what it was."""


def improve(state: Improvement, begin: Outcome, reserve: int) -> Outcome:
    """Change a recipe until every requirement is met, nothing improves it, or only the reserve of analyses is left."""
    context, now = state.context, begin
    state.too_dear = None
    context.ended.pop(_STAGE, None)
    while now.attainable and context.runner.left > reserve:
        left = context.runner.left - reserve
        context.runner.estimate.improving((context.first.shortfall, now.shortfall), context.runner.used, left)
        better = _next_change(state, now, reserve)
        if better is None:
            _note_end(state)
            break
        changes, after = better
        context.accept([change.what for change in changes], now, after)
        now = after
    return now


def _note_end(state: Improvement) -> None:
    context = state.context
    if state.too_dear is not None:
        price, what = state.too_dear
        context.ended[_STAGE] = (
            f"What is not met yet costs more than it is worth: {price:.0f} s for one more requirement by {what}, and "
            f"{context.request.worth.requirement_s:g} s are allowed."
        )
    elif context.runner.left > 0:
        context.ended[_STAGE] = "Of the allowed changes none improves what is not met yet."


def _next_change(state: Improvement, now: Outcome, reserve: int) -> tuple[Sequence[Change], Outcome] | None:
    runner = state.context.runner
    ranked, bundle, taken = _ranked(state, now), list[Change](), set[str]()
    for change in ranked:  # the best change, and the best of other uses: washing and rinsing are changed at once
        uses = {str(now.use_of(step)) for step in change.steps}
        if uses and not uses & taken:
            bundle.append(change)
            taken |= uses
    tries = [bundle] if len(bundle) > 1 else []
    for changes in [*tries, *([change] for change in ranked[:_MOST_TRIED])]:
        if runner.left <= reserve:
            return None
        candidate = _within_limits(state, now, changes)
        after = None if candidate is None else runner.outcome(candidate.text)
        gained = 0.0 if after is None else now.shortfall - after.shortfall
        share = gained / max(sum(change.most_gain for change in changes), 1e-9)
        if len(changes) == 1 or share > 0:  # of several at once, none loses confidence for long
            for change in changes:
                factor = min(1.0, max(CONFIDENCE_DECAY, share))
                state.confidence[change.group] = factor * state.confidence.get(change.group, 1.0)
        if after is not None and gained > _LEAST_GAIN * now.shortfall and _is_worth_it(state, changes, now, after):
            return changes, after
        _lower_priorities(state, now, changes, after)
    return None


def _is_worth_it(state: Improvement, changes: Sequence[Change], now: Outcome, after: Outcome) -> bool:
    """Whether what is gained costs no more seconds and litres than it is worth."""
    worth = state.context.request.worth
    price = worth.added_s(now, after) / (now.shortfall - after.shortfall)
    if price <= worth.requirement_s:
        return True
    if state.too_dear is None or price < state.too_dear[0]:
        state.too_dear = price, " and ".join(change.what for change in changes)
    return False


def _lower_priorities(state: Improvement, now: Outcome, changes: Sequence[Change], after: Outcome | None) -> None:
    """Requirements that a change failed to improve get a lower priority, so that changes for others come first."""
    left = {} if after is None else {unmet.key: unmet.deficit for unmet in after.unmet}
    targets = frozenset(key for change in changes for key in change.targets)
    for unmet in now.attainable:
        if unmet.key in targets and (after is None or left.get(unmet.key, 0.0) > _NOT_IMPROVED * unmet.deficit):
            state.priority[unmet.key] = PRIORITY_DECAY * state.priority.get(unmet.key, 1.0)


def _ranked(state: Improvement, now: Outcome) -> list[Change]:
    """Plan the most promising changes, leave out what breaks a limit, and sort by gain for the cost."""

    def confidence(change: Change) -> float:
        return state.confidence.get(change.group, 1.0)

    unmet = [replace(each, priority=state.priority.get(each.key, 1.0)) for each in now.attainable]
    promising = sorted(
        candidate_changes(now, unmet, state.context.request.allowed),
        key=lambda change: -round(confidence(change) * change.most_gain, 6),
    )
    ranked: list[tuple[float, Change]] = []
    for change in promising[:_MOST_PLANNED]:
        candidate = _within_limits(state, now, [change])
        if candidate is not None:
            longer = candidate.seconds - now.seconds
            cost = max(longer, 0.0) + _COST_SHARE * now.seconds + _COST_S
            ranked.append((round(confidence(change) * change.gain_in(longer) / cost, 9), change))
    return [change for _, change in sorted(ranked, key=lambda each: -each[0])]


def _within_limits(state: Improvement, now: Outcome, changes: Sequence[Change]) -> Candidate | None:
    """Plan changes; ``None`` where that cannot be done or leads farther beyond the limits."""
    edits = tuple(edit for change in changes for edit in change.edits)
    candidate = state.context.runner.candidate(now.text, edits)
    if candidate is None or state.context.excess(candidate) > state.context.excess(now):
        return None
    return candidate

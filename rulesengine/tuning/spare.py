"""How far a cut may probably go: from what holds with room to spare, and who sprays it."""

from collections.abc import Iterator

from rulesengine.tuning.effects import steps_for, template_share
from rulesengine.tuning.goals import Spare
from rulesengine.tuning.outcome import Outcome


def likely(outcome: Outcome, steps: frozenset[str], template: str, saved_s: float) -> float:
    """Estimate which share of a cut holds, 0 to 1; an analysis has the last word.

    Args:
        outcome: Of the recipe before the cut.
        steps: Where it acts.
        template: Of which it takes something away; empty: of the whole steps.
        saved_s: Time that the whole cut saves.
    """
    return min(
        (share for spare in outcome.spares for share in _allowed(spare, outcome, steps, template, saved_s)), default=1.0
    )


def _allowed(spare: Spare, outcome: Outcome, steps: frozenset[str], template: str, saved_s: float) -> Iterator[float]:
    concerned = steps_for(spare, outcome)
    if not concerned & steps:
        return
    room = 1.0 - spare.needed
    if spare.judgement.rule == "R7":
        seconds = sum(step.seconds for step in outcome.steps if step.made_by in concerned)
        yield room * seconds / saved_s if saved_s > 0 else 1.0
    else:
        taken = template_share(spare.component, template, concerned, outcome) if template else 1.0
        yield room / taken if taken > 0 else 1.0

"""How far a cut may probably go: from what holds with room to spare, and who sprays it."""

from collections.abc import Iterator

from cleaning.verdicts.rules import INCOMPLETE_RINSE, IONIC_RESIDUE, NOT_FLUSHED, RESIDUE_LEFT, UNDER_EXPOSED
from rulesengine.tuning.changes.expected_effect import arrives_nowhere, steps_for, template_share
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.requirements import Spare, Want

_AMOUNTS = frozenset({UNDER_EXPOSED, NOT_FLUSHED, RESIDUE_LEFT, INCOMPLETE_RINSE, IONIC_RESIDUE})
_DOUBT = 0.35
"""The least wetted places of a surface may get all they have from elsewhere."""
_HARDLY = 0.02
"""Share of what a component gets that it will not miss."""


def likely(outcome: Outcome, steps: frozenset[str], template: str, saved_s: float) -> float:
    """Estimate which share of a cut holds, 0 to 1; an analysis has the last word.

    Args:
        outcome: Of the recipe before the cut.
        steps: Where it acts.
        template: Of which it takes something away.
        saved_s: Time that the whole cut saves.
    """
    if any(_starves(want, outcome, steps, template) for want in outcome.mendable):
        return 0.0
    return min(
        (share for spare in outcome.spares for share in _allowed(spare, outcome, steps, template, saved_s)), default=1.0
    )


def _starves(want: Want, outcome: Outcome, steps: frozenset[str], template: str) -> bool:
    """Whether a cut takes away from what has too little of it already."""
    concerned = steps_for(want, outcome)
    if want.judgement.rule not in _AMOUNTS or arrives_nowhere(want) or not concerned & steps:
        return False
    return want.judgement.rule == RESIDUE_LEFT or template_share(want.component, template, concerned, outcome) > _HARDLY


def _allowed(spare: Spare, outcome: Outcome, steps: frozenset[str], template: str, saved_s: float) -> Iterator[float]:
    concerned = steps_for(spare, outcome)
    if not concerned & steps:
        return
    room = 1.0 - spare.needed
    if spare.judgement.rule == RESIDUE_LEFT:
        yield room * outcome.seconds_in(concerned) / saved_s if saved_s > 0 else 1.0
    else:
        taken = template_share(spare.component, template, concerned, outcome)
        yield max(room / taken if taken > 0 else 1.0, _DOUBT)

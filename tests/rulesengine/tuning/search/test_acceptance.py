"""Acceptance test of shorter recipes."""

from types import SimpleNamespace

from cleaning.verdicts.results import Judgement
from cleaning.verdicts.rules import (
    INCOMPLETE_RINSE,
    MISSED,
    NOT_FLUSHED,
    ONE_SIDED,
    PLUGGED_GAP,
    PROCESS_WINDOW,
    RESIDUE_LEFT,
    SPENT_BATH,
    UNDER_EXPOSED,
)
from rulesengine.tuning.search.acceptance import Acceptance
from rulesengine.tuning.trial.requirements import PROCESS, UnmetRequirement, attainable


def unmet(component, rule, deficit=0.5, verdict="dirty", stage=""):
    return UnmetRequirement(
        component,
        Judgement(rule=rule, verdict=verdict, because="because", advice="advice", stage=stage),
        deficit,
    )


def outcome(*requirements):
    return SimpleNamespace(unmet=requirements)


PLUGGED = unmet("U3", PLUGGED_GAP, 1.0)
UNHIT = unmet("J1", MISSED, 0.03, "marginal", "sequence[0]")
LITTLE = unmet("C1", UNDER_EXPOSED, 0.2, "marginal", "sequence[0]")


def test_what_no_recipe_can_meet_is_left_out():
    flows = tuple(unmet("U3", rule) for rule in (NOT_FLUSHED, RESIDUE_LEFT, ONE_SIDED, INCOMPLETE_RINSE))
    bath, water = unmet(PROCESS, SPENT_BATH), unmet(PROCESS, INCOMPLETE_RINSE)
    others = (LITTLE, unmet("U4", RESIDUE_LEFT), unmet("U3", UNDER_EXPOSED), unmet(PROCESS, PROCESS_WINDOW))
    assert attainable((PLUGGED, *flows, bath, water, *others)) == others


def test_no_more_may_be_unmet_in_number_or_in_all():
    acceptance = Acceptance(outcome(LITTLE, UNHIT), frozenset())
    assert acceptance.accepts(outcome(LITTLE, UNHIT))
    assert acceptance.accepts(outcome(UNHIT))
    assert not acceptance.accepts(outcome(LITTLE, UNHIT, unmet("C2", UNDER_EXPOSED, 0.0)))
    assert not acceptance.accepts(outcome(unmet("C1", UNDER_EXPOSED, 0.3, "marginal", "sequence[0]"), UNHIT))
    assert Acceptance(outcome(), frozenset()).accepts(outcome())
    assert not Acceptance(outcome(), frozenset()).accepts(outcome(LITTLE))


def test_what_is_unattainable_may_lose_something_but_not_its_verdict():
    acceptance = Acceptance(outcome(UNHIT), frozenset({UNHIT.key}))
    assert acceptance.accepts(outcome(unmet("J1", MISSED, 0.045, "marginal", "sequence[0]")))
    assert not acceptance.accepts(outcome(unmet("J1", MISSED, 1.06, "dirty", "sequence[0]")))
    assert not acceptance.accepts(outcome(UNHIT, LITTLE))


def test_amounts_that_come_to_be_judged_where_less_is_missed_are_no_loss():
    much = unmet("J1", MISSED, 1.06, "dirty", "sequence[0]")
    amounts = unmet("J1", UNDER_EXPOSED, 1.0, "dirty", "sequence[0]")
    acceptance = Acceptance(outcome(much), frozenset({much.key, amounts.key}))
    assert acceptance.accepts(outcome(UNHIT, amounts))

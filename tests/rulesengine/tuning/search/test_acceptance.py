"""What a shorter recipe is held against."""

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
from rulesengine.tuning.search.acceptance import Standard
from rulesengine.tuning.trial.lower_bound import key_of
from rulesengine.tuning.trial.requirements import PROCESS, Want, mendable


def want(component, rule, deficit=0.5, verdict="dirty", stage=""):
    return Want(
        component,
        Judgement(rule=rule, verdict=verdict, because="because", advice="advice", stage=stage),
        deficit,
    )


def outcome(*wants):
    return SimpleNamespace(wants=wants)


PLUGGED = want("U3", PLUGGED_GAP, 1.0)
UNHIT = want("J1", MISSED, 0.03, "marginal", "sequence[0]")
LITTLE = want("C1", UNDER_EXPOSED, 0.2, "marginal", "sequence[0]")


def test_what_no_recipe_mends_is_known():
    flows = tuple(want("U3", rule) for rule in (NOT_FLUSHED, RESIDUE_LEFT, ONE_SIDED, INCOMPLETE_RINSE))
    bath, water = want(PROCESS, SPENT_BATH), want(PROCESS, INCOMPLETE_RINSE)
    others = (LITTLE, want("U4", RESIDUE_LEFT), want("U3", UNDER_EXPOSED), want(PROCESS, PROCESS_WINDOW))
    assert mendable((PLUGGED, *flows, bath, water, *others)) == others


def test_no_more_may_be_wanting_in_number_or_in_all():
    standard = Standard(outcome(LITTLE, UNHIT), frozenset())
    assert standard.holds(outcome(LITTLE, UNHIT))
    assert standard.holds(outcome(UNHIT))
    assert not standard.holds(outcome(LITTLE, UNHIT, want("C2", UNDER_EXPOSED, 0.0)))
    assert not standard.holds(outcome(want("C1", UNDER_EXPOSED, 0.3, "marginal", "sequence[0]"), UNHIT))
    assert Standard(outcome(), frozenset()).holds(outcome())
    assert not Standard(outcome(), frozenset()).holds(outcome(LITTLE))


def test_what_is_hopeless_may_lose_something_but_not_its_verdict():
    standard = Standard(outcome(UNHIT), frozenset({key_of(UNHIT)}))
    assert standard.holds(outcome(want("J1", MISSED, 0.045, "marginal", "sequence[0]")))
    assert not standard.holds(outcome(want("J1", MISSED, 1.06, "dirty", "sequence[0]")))
    assert not standard.holds(outcome(UNHIT, LITTLE))


def test_amounts_that_come_to_be_judged_where_less_is_missed_are_no_loss():
    much = want("J1", MISSED, 1.06, "dirty", "sequence[0]")
    amounts = want("J1", UNDER_EXPOSED, 1.0, "dirty", "sequence[0]")
    standard = Standard(outcome(much), frozenset({key_of(much), key_of(amounts)}))
    assert standard.holds(outcome(UNHIT, amounts))

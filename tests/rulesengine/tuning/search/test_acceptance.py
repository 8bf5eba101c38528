"""What a shorter recipe is held against."""

from types import SimpleNamespace

from cleaning.verdicts.results import Judgement
from rulesengine.tuning.search.acceptance import Standard
from rulesengine.tuning.trial.lower_bound import key_of
from rulesengine.tuning.trial.requirements import PROCESS, Want, mendable


def want(component, rule, deficit=0.5, verdict="dirty", stage=""):
    return Want(component, Judgement(rule, "", verdict, "A", (), "because", "advice", stage), deficit)


def outcome(*wants):
    return SimpleNamespace(wants=wants)


PLUGGED = want("U3", "R5", 1.0)
MISSED = want("J1", "R1", 0.03, "marginal", "sequence[0]")
LITTLE = want("C1", "R2", 0.2, "marginal", "sequence[0]")


def test_what_no_recipe_mends_is_known():
    flows = tuple(want("U3", rule) for rule in ("R6", "R7", "R8", "R10"))
    bath, water = want(PROCESS, "R9"), want(PROCESS, "R10")
    others = (LITTLE, want("U4", "R7"), want("U3", "R2"), want(PROCESS, "R13"))
    assert mendable((PLUGGED, *flows, bath, water, *others)) == others


def test_no_more_may_be_wanting_in_number_or_in_all():
    standard = Standard(outcome(LITTLE, MISSED), frozenset())
    assert standard.holds(outcome(LITTLE, MISSED))
    assert standard.holds(outcome(MISSED))
    assert not standard.holds(outcome(LITTLE, MISSED, want("C2", "R2", 0.0)))
    assert not standard.holds(outcome(want("C1", "R2", 0.3, "marginal", "sequence[0]"), MISSED))
    assert Standard(outcome(), frozenset()).holds(outcome())
    assert not Standard(outcome(), frozenset()).holds(outcome(LITTLE))


def test_what_is_hopeless_may_lose_something_but_not_its_verdict():
    standard = Standard(outcome(MISSED), frozenset({key_of(MISSED)}))
    assert standard.holds(outcome(want("J1", "R1", 0.045, "marginal", "sequence[0]")))
    assert not standard.holds(outcome(want("J1", "R1", 1.06, "dirty", "sequence[0]")))
    assert not standard.holds(outcome(MISSED, LITTLE))


def test_amounts_that_come_to_be_judged_where_less_is_missed_are_no_loss():
    much = want("J1", "R1", 1.06, "dirty", "sequence[0]")
    amounts = want("J1", "R2", 1.0, "dirty", "sequence[0]")
    standard = Standard(outcome(much), frozenset({key_of(much), key_of(amounts)}))
    assert standard.holds(outcome(MISSED, amounts))

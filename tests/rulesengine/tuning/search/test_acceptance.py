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
from rulesengine.tuning.search.moves import Acceptance
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest, Worth
from rulesengine.tuning.trial.requirements import PROCESS, UnmetRequirement, attainable, total_shortfall


def unmet(component, rule, deficit=0.5, verdict="dirty", stage=""):
    return UnmetRequirement(
        component,
        Judgement(rule=rule, verdict=verdict, because="because", advice="advice", stage=stage),
        deficit,
    )


def outcome(*requirements, seconds=100.0, litres=4.0):
    return SimpleNamespace(unmet=requirements, seconds=seconds, litres=litres, shortfall=total_shortfall(requirements))


def acceptance_of(reference, unattainable=frozenset(), limits=None, worth=None):
    request = TuningRequest(
        "clean", limits or ProgramLimits(), AllowedChanges(frozenset()), 40, worth or Worth(0.01, 100.0)
    )
    return Acceptance(request, reference, unattainable)


PLUGGED = unmet("U3", PLUGGED_GAP, 1.0)
UNHIT = unmet("J1", MISSED, 0.03, "marginal", "sequence[0]")
LITTLE = unmet("C1", UNDER_EXPOSED, 0.2, "marginal", "sequence[0]")


def test_what_no_recipe_can_meet_is_left_out():
    flows = tuple(unmet("U3", rule) for rule in (NOT_FLUSHED, RESIDUE_LEFT, ONE_SIDED, INCOMPLETE_RINSE))
    bath, water = unmet(PROCESS, SPENT_BATH), unmet(PROCESS, INCOMPLETE_RINSE)
    others = (LITTLE, unmet("U4", RESIDUE_LEFT), unmet("U3", UNDER_EXPOSED), unmet(PROCESS, PROCESS_WINDOW))
    assert attainable((PLUGGED, *flows, bath, water, *others)) == others


def test_no_more_may_be_unmet_in_number_or_in_all():
    acceptance = acceptance_of(outcome(LITTLE, UNHIT))
    assert acceptance.keeps(outcome(LITTLE, UNHIT))
    assert acceptance.keeps(outcome(UNHIT))
    assert not acceptance.keeps(outcome(LITTLE, UNHIT, unmet("C2", UNDER_EXPOSED, 0.0)))
    assert not acceptance.keeps(outcome(unmet("C1", UNDER_EXPOSED, 0.3, "marginal", "sequence[0]"), UNHIT))
    assert acceptance_of(outcome()).keeps(outcome())
    assert not acceptance_of(outcome()).keeps(outcome(LITTLE))


def test_what_is_unattainable_may_lose_something_but_not_its_verdict():
    acceptance = acceptance_of(outcome(UNHIT), frozenset({UNHIT.key}))
    assert acceptance.keeps(outcome(unmet("J1", MISSED, 0.045, "marginal", "sequence[0]")))
    assert not acceptance.keeps(outcome(unmet("J1", MISSED, 1.06, "dirty", "sequence[0]")))
    assert not acceptance.keeps(outcome(UNHIT, LITTLE))


def test_amounts_that_come_to_be_judged_where_less_is_missed_are_no_loss():
    much = unmet("J1", MISSED, 1.06, "dirty", "sequence[0]")
    amounts = unmet("J1", UNDER_EXPOSED, 1.0, "dirty", "sequence[0]")
    acceptance = acceptance_of(outcome(much), frozenset({much.key, amounts.key}))
    assert acceptance.keeps(outcome(UNHIT, amounts))


def test_what_is_as_clean_has_to_be_shorter_with_no_more_liquid():
    acceptance = acceptance_of(outcome(UNHIT))
    assert acceptance.accepts(outcome(UNHIT, seconds=99.9))
    assert acceptance.accepts(outcome(UNHIT, seconds=99.9, litres=3.9))
    assert not acceptance.accepts(outcome(UNHIT))
    assert not acceptance.accepts(outcome(UNHIT, litres=3.9))
    assert not acceptance.accepts(outcome(UNHIT, seconds=99.9, litres=4.1))
    assert not acceptance.accepts(outcome(UNHIT, LITTLE, seconds=50.0, litres=2.0))
    assert not acceptance.accepts(outcome(unmet("J1", MISSED, 0.06, "marginal", "sequence[0]"), seconds=50.0))


def test_what_is_cleaner_may_cost_its_price_and_no_more():
    acceptance = acceptance_of(outcome(unmet("U1", RESIDUE_LEFT, 0.9), unmet("U2", RESIDUE_LEFT, 0.9)))
    better = unmet("U1", RESIDUE_LEFT, 0.9)  # one requirement, of the weight of its deficit and a tenth, is met
    assert acceptance.accepts(outcome(better, seconds=200.0, litres=8.0))
    assert not acceptance.accepts(outcome(better, seconds=200.1, litres=8.0))
    assert not acceptance.accepts(outcome(better, seconds=200.0, litres=8.1))
    assert acceptance.accepts(outcome(better, seconds=300.0, litres=4.0)), "liquid and time count half each"
    hardly = unmet("U2", RESIDUE_LEFT, 0.8905)  # less than half a percent of the shortfall
    assert not acceptance.accepts(outcome(better, hardly, seconds=100.5))
    assert acceptance.accepts(outcome(better, unmet("U2", RESIDUE_LEFT, 0.8895), seconds=100.5))
    assert acceptance.price_s(outcome(better, seconds=150.0, litres=6.0)) == 50.0
    assert acceptance.price_s(outcome(better, seconds=50.0)) == 0.0


def test_beyond_the_limits_only_what_leads_nearer_counts_and_within_nothing_leads_out():
    limits = ProgramLimits(seconds=80.0, litres=5.0)
    beyond = acceptance_of(outcome(), limits=limits)
    assert beyond.accepts(outcome(LITTLE, PLUGGED, seconds=90.0))
    assert not beyond.accepts(outcome(seconds=110.0))
    assert not beyond.accepts(outcome(seconds=90.0, litres=6.0))
    within = acceptance_of(outcome(PLUGGED, LITTLE, seconds=80.0), limits=limits)
    assert not within.accepts(outcome(seconds=81.0))
    assert not within.accepts(outcome(seconds=70.0, litres=5.1))
    assert within.accepts(outcome(LITTLE, seconds=80.0, litres=5.0))
    assert within.accepts(outcome(PLUGGED, LITTLE, seconds=79.0))


def test_what_saves_as_much_as_an_analysis_is_worth_needs_no_other_speeds():
    acceptance = acceptance_of(outcome())
    assert acceptance.saves(outcome(seconds=98.0))
    assert acceptance.saves(outcome(seconds=99.0, litres=3.96))
    assert not acceptance.saves(outcome(seconds=98.1))
    assert not acceptance.saves(outcome(seconds=90.0, litres=4.01))

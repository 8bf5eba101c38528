from dataclasses import replace

import pytest
from cleaning_report import small_report
from hypothesis import given
from hypothesis import strategies as st

from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import MISSED, RESIDUE_LEFT, UNDER_EXPOSED, WET_GAP
from rulesengine.tuning.trial.requirements import deficit, met_requirements, total_shortfall, unmet_requirements


def judgement(rule, *numbers, verdict="dirty", name=""):
    return Judgement(rule=rule, variant=name, verdict=verdict, numbers=numbers, because="because", advice="advice")


def amount(value):
    return judgement(UNDER_EXPOSED, Number("volume, 5th percentile", value, "mm", 5.0))


def residue(percent):
    return judgement(RESIDUE_LEFT, Number("residue", percent, "%", 5.0))


@given(st.floats(0, 5), st.floats(0, 5))
def test_who_gets_more_lacks_less(one, other):
    less, more = sorted((one, other))
    assert 0 <= deficit(amount(more)) <= deficit(amount(less)) <= 1


@given(st.floats(5, 100), st.floats(5, 100))
def test_who_keeps_more_residue_lacks_more(one, other):
    less, more = sorted((one, other))
    assert 0 <= deficit(residue(less)) <= deficit(residue(more)) <= 1


def test_what_just_holds_lacks_nothing():
    assert deficit(amount(5.0)) == pytest.approx(0)
    assert deficit(residue(5.0)) == pytest.approx(0)


def test_residue_counts_by_the_time_that_is_missing():
    # exp(-k t): half of the time leaves the square root of the share.
    assert deficit(residue(100 * 0.05**0.5)) == pytest.approx(0.5)


def test_a_surface_that_is_missed_lacks_more_than_one_that_gets_too_little():
    missed = judgement(MISSED, Number("missed", 6.0, "%", 1.0))
    more = judgement(MISSED, Number("missed", 40.0, "%", 1.0))
    never = judgement(MISSED, name="not sprayed")
    assert deficit(amount(0.0)) < deficit(missed) < deficit(more) < deficit(never)


@pytest.mark.parametrize("verdict", ["clean", "no verdict"])
def test_what_is_clean_or_beyond_the_model_is_not_asked_for(verdict):
    report = small_report()
    calm = tuple(replace(part, judgements=(replace(amount(1.0), verdict=verdict),)) for part in report.parts)
    assert unmet_requirements(replace(report, parts=calm), "clean", frozenset()) == ()


def test_water_under_parts_counts_where_dryness_is_asked_for():
    report = small_report()
    wet = judgement(WET_GAP, Number("gap", 30, "um"), Number("least gap that is blown clear", 60, "um"))
    parts = (replace(report.parts[0], judgements=(wet,)),)
    assert unmet_requirements(replace(report, parts=parts), "clean", frozenset()) == ()
    (unmet,) = unmet_requirements(replace(report, parts=parts), "clean-and-dry", frozenset())
    assert unmet.deficit == pytest.approx(0.5)
    nearly = replace(wet, numbers=(*wet.numbers, Number("time to evaporate", 20, "s", 15)))
    assert deficit(nearly) == pytest.approx(0.25)


def test_what_masks_take_out_is_not_asked_for():
    report = small_report()
    names = {unmet.component for unmet in unmet_requirements(report, "clean", frozenset())}
    assert {"U1", "R1"} <= names
    assert "U1" not in {unmet.component for unmet in unmet_requirements(report, "clean", frozenset({"U1"}))}


def test_each_judgement_adds_to_the_shortfall():
    wants = unmet_requirements(small_report(), "clean", frozenset())
    assert total_shortfall(()) == 0
    assert 0 < total_shortfall(wants[:1]) < total_shortfall(wants)


def test_what_holds_says_how_much_it_needs():
    report = small_report()
    kept = (replace(amount(10.0), verdict="clean"), replace(residue(100 * 0.05**2), verdict="clean"))
    spares = met_requirements(replace(report, parts=(replace(report.parts[0], judgements=kept),)), frozenset())
    assert [spare.needed for spare in spares[:2]] == pytest.approx([0.5, 0.5])

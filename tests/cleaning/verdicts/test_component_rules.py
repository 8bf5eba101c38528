from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from judged import USES, evidence, exposed, gap, gap_stage, stage, underside

from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import PartOverride, Provenance
from cleaning.verdicts.component_rules import judge_part
from cleaning.verdicts.gap_rules import compass
from cleaning.verdicts.process_rules import judge_process
from cleaning.verdicts.results import Reach
from cleaning.verdicts.rules import RULES, VERDICTS

PARAMETERS = load_parameters()


def rules(judgements, verdict=None):
    return [each.rule.id for each in judgements if verdict in (None, each.verdict)]


def one(judgements, rule):
    found = [each for each in judgements if each.rule.id == rule]
    assert len(found) == 1
    return found[0]


def with_limits(**changes):
    return PARAMETERS.model_copy(update={"limits": PARAMETERS.limits.model_copy(update=changes)})


def washed(**numbers):
    seen = exposed(**numbers)
    return evidence(exposed=(seen, exposed(), exposed()), reached=(Reach("wash", "clean", "sequence[0]", 1, seen),))


def test_what_is_well_is_said_to_be_clean_with_its_numbers():
    judged = judge_part(evidence((gap(),)))
    assert {each.verdict for each in judged} == {"clean"}
    assert one(judged, "R7").numbers[0].value == pytest.approx(1.0)
    assert all(each.numbers for each in judged)
    assert {each.advice for each in judged} == {""}


def test_a_component_on_a_side_that_nothing_sprays_is_dirty():
    judged = judge_part(evidence(reached=(), exposed=(None, None, None), side="bottom"))
    assert rules(judged) == ["R1"]
    assert judged[0].verdict == "dirty"
    assert "side: bottom" in judged[0].advice


def test_what_is_never_hit_is_missed_and_what_stands_before_it_is_named():
    assert one(judge_part(washed(missed=0.03)), "R1").name == "missed"
    assert one(judge_part(washed(missed=0.03)), "R1").verdict == "marginal"
    assert one(judge_part(washed(missed=0.3)), "R1").verdict == "dirty"
    assert rules(judge_part(washed(missed=0.005)), "dirty") == []
    shadowed = evidence(exposed=(exposed(missed=0.3),) * 3, reached=washed(missed=0.3).reached, occluder="U3")
    assert one(judge_part(shadowed), "R1").name == "shadowed"
    assert "U3" in one(judge_part(shadowed), "R1").because


@pytest.mark.parametrize(
    ("low", "verdict"), [(10.0, "clean"), (9.9, "marginal"), (5.0, "marginal"), (2.5, "marginal"), (2.4, "dirty")]
)
def test_the_least_wetted_places_decide_on_exposure(low, verdict):
    judged = one(judge_part(washed(low=low)), "R2")
    assert judged.verdict == verdict
    assert judged.grade == "C"
    assert judged.numbers[0].limit == 10.0  # clean with a margin: twice the 5 mm
    assert "(limit 5 mm, clean from 10 mm)" in judged.because


@pytest.mark.parametrize(
    ("low", "margin", "verdict"), [(5.0, 1.0, "clean"), (10.0, 3.0, "marginal"), (15.0, 3.0, "clean")]
)
def test_the_margin_is_a_limit_like_the_others(low, margin, verdict):
    judged = one(judge_part(replace(washed(low=low), parameters=with_limits(margin=margin))), "R2")
    assert judged.verdict == verdict
    assert ("clean from" in judged.because) == (margin > 1)


def test_what_flows_over_a_surface_counts_and_what_lands_is_stated():
    wet = replace(exposed(low=1.0), supply_mm=(0.5, 12.0, 18.0))
    judged = one(judge_part(evidence(reached=(Reach("wash", "clean", "sequence[0]", 1, wet),))), "R2")
    assert judged.verdict == "clean"
    assert [each.value for each in judged.numbers] == [12.0, 1.0]
    assert "get 12 mm in clean, run-off included" in judged.because


def test_rinsing_has_its_own_limit_and_the_wave_front_counts_where_it_is_asked_for():
    rinsed = evidence(reached=(Reach("rinse", "rinse", "sequence[1]", 1, exposed(low=4.1)),))
    assert one(judge_part(rinsed), "R2").verdict == "clean"
    hurried = evidence(reached=washed(front=1.0).reached, parameters=with_limits(front_s=1.5))
    assert one(judge_part(hurried), "R2").verdict == "marginal"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("low", "repeats", "verdict", "says"),
    [(1.4, 4, "clean", "3 times, of 4 at most"), (0.8, 4, "marginal", "even if done 4 times"), (4.0, 4, "clean", "")],
)
def test_a_loop_may_make_up_for_what_doing_it_once_lacks(low, repeats, verdict, says):
    rinsed = evidence(reached=(Reach("rinse", "rinse", "sequence[1]", repeats, exposed(low=low)),))
    judged = one(judge_part(rinsed), "R2")
    assert judged.verdict == verdict
    assert says in judged.because
    assert ("times" in judged.because) == bool(says)


def test_the_rinse_under_a_part_counts_as_often_as_it_may_be_done():
    stages = (stage("wash"), stage("rinse", repeats=4), stage("dry"))
    judged = judge_part(evidence((gap(rinse={"exchanges": 2.0}),), stages=stages))
    assert "R10" not in rules(judged)


def test_without_a_wash_nothing_is_said_of_residue():
    unwashed = replace(gap(), stages=(None, gap().stages[1], None))
    judged = judge_part(evidence((unwashed,)))
    assert one(judged, "R14").verdict == "no verdict"
    assert "R7" not in rules(judged)


def test_a_part_that_shadows_itself_is_not_named_as_another():
    assert "its own body" in one(judge_part(replace(washed(missed=0.3), occluder="U1")), "R1").because


def test_a_part_that_bears_less_than_the_spray_gives_is_at_risk():
    weak = evidence(override=PartOverride(match=["U1"], most_kpa=0.2, window_c=(0, 50)))
    judged = judge_part(weak)
    assert len([each for each in judged if each.rule.id == "R3"]) == 3
    assert "0.2 kPa" in judged[0].because
    assert len([each for each in judged if each.rule.id == "R13"]) == 3
    strong = evidence(override=PartOverride(match=["U1"], most_kpa=0.4, window_c=(0, 70)))
    assert {"R3", "R13"}.isdisjoint(rules(judge_part(strong)))


def test_a_gap_that_stays_dry_is_never_clean():
    dry = gap(wash={"margin_pa": -120.0, "entered": False}, residue=0.0)
    judged = judge_part(evidence((dry,)))
    assert judged[0].rule.id == "R4"
    assert judged[0].verdict == "dirty"
    assert "120 Pa" in judged[0].because
    assert "R7" not in rules(judged)
    never = gap(wash={"margin_pa": 500.0, "entered": False})
    assert "never reaches" in one(judge_part(evidence((never,))), "R4").because


def test_a_plugged_gap_is_dirty():
    assert one(judge_part(evidence((gap(fill=0.85),))), "R5").verdict == "dirty"
    assert "R5" not in rules(judge_part(evidence((gap(fill=0.84),))))


@pytest.mark.parametrize(("done", "verdict"), [(4.0, "dirty"), (6.0, "marginal")])
def test_residue_that_cannot_be_carried_away_is_not_flushed(done, verdict):
    assert one(judge_part(evidence((gap(wash={"exchanges": done}),))), "R6").verdict == verdict


@pytest.mark.parametrize(
    ("residue", "worst", "verdict", "name"),
    [
        (0.025, 0.5, "clean", "residue"),
        (0.026, 0.1, "marginal", "residue"),
        (0.05, 0.1, "marginal", "residue"),
        (0.06, 0.1, "marginal", "residue"),
        (0.21, 0.9, "dirty", "residue"),
        (0.02, 0.6, "marginal", "pocket"),
    ],
)
def test_residue_is_judged_by_its_mean_and_its_worst_tenth(residue, worst, verdict, name):
    judged = one(judge_part(evidence((gap(residue=residue, residue_worst=worst),))), "R7")
    assert (judged.verdict, judged.name, judged.grade) == (verdict, name, "C")
    assert bool(judged.advice) is (verdict != "clean")
    thin = "within the limit of 5 %; clean with a margin is 2.5 %" in judged.because
    assert thin == (0.025 < residue <= 0.05)


def test_a_pocket_is_where_it_is_on_the_board():
    turned = evidence((gap(residue=0.5),), underside=underside(turn_rad=np.pi / 2))
    assert one(judge_part(turned), "R7").where == pytest.approx((10.0, 21.0, 0.0))


def test_calibrated_kinetics_raise_the_grade():
    fitted = Provenance(known="calibrated", source="coupons", samples=24)
    made_up = Provenance(known="synthetic", source="demo", samples=24)
    for provenance, grade in ((fitted, "B"), (made_up, "C")):
        known = {**PARAMETERS.provenance, "soil.k1_per_s": provenance, "soil.k_m_per_s": provenance}
        judged = judge_part(evidence((gap(),), PARAMETERS.model_copy(update={"provenance": known})))
        assert one(judged, "R7").grade == grade


@pytest.mark.parametrize("turn", [0.0, np.pi / 2, 0.3])
@pytest.mark.parametrize("weakest", range(4))
def test_flow_from_one_side_names_the_direction_that_is_missing(turn, weakest):
    shear = [1.0, 1.0, 1.0, 1.0]
    shear[weakest] = 0.01
    weak = gap(wash={"weak_share": 0.3, "side_shear_pa": tuple(shear)})
    judged = one(judge_part(evidence((weak,), underside=underside(turn))), "R8")
    at_rest = ((0, -1), (1, 0), (0, 1), (-1, 0))[weakest]
    cos, sin = np.cos(turn), np.sin(turn)
    assert judged.sides[0] == pytest.approx((cos * at_rest[0] - sin * at_rest[1], sin * at_rest[0] + cos * at_rest[1]))
    assert compass(judged.sides[0]) in judged.advice


def test_rinsing_under_a_part_asks_for_seven_exchanges():
    judged = one(judge_part(evidence((gap(rinse={"exchanges": 3.0}),))), "R10")
    assert judged.verdict == "marginal"
    assert "3 times as long" in judged.advice
    assert one(judge_part(evidence((gap(rinse={"exchanges": 1.0}),))), "R10").verdict == "dirty"
    assert "R10" not in rules(judge_part(evidence((gap(rinse={"exchanges": 7.0}),))))


def test_an_ionic_limit_counts_only_where_the_user_set_one():
    salty = gap(ionic_ug_cm2=5.0)
    assert "R11" not in rules(judge_part(evidence((salty,))))
    assert one(judge_part(evidence((salty,), with_limits(ionic_ug_cm2=2.0))), "R11").verdict == "dirty"


def test_water_that_cannot_be_blown_out_may_evaporate_while_the_board_is_warm():
    # the air is at 60 degrees for 10 s
    for seconds, verdict in ((8.0, "clean"), (12.0, "marginal"), (inf, "marginal")):
        judged = one(judge_part(evidence((gap(blow_off_um=80.0, dry_s=seconds),))), "R12")
        assert judged.verdict == verdict
        assert "it is warm for 10 s" in judged.because
    kept = PARAMETERS.drying.model_copy(update={"dwell_min": 0.5})
    slow = judge_part(evidence((gap(blow_off_um=80.0, dry_s=39.0),), PARAMETERS.model_copy(update={"drying": kept})))
    assert one(slow, "R12").verdict == "clean"
    assert "R12" not in rules(judge_part(evidence((gap(blow_off_um=40.0, dry_s=99.0),))))


def test_only_the_warmest_air_counts_for_evaporation():
    stages = (*(stage(use) for use in USES), stage("dry", temperature_c=80.0, begin_s=10.0, end_s=25.0))
    seen = exposed()
    for seconds, verdict in ((14.0, "clean"), (16.0, "marginal")):
        left = replace(gap(blow_off_um=80.0, dry_s=seconds), stages=(gap_stage(), gap_stage(), None, None))
        found = judge_part(evidence((left,), stages=stages, exposed=(seen,) * 4))
        assert one(found, "R12").verdict == verdict


def test_water_that_cannot_be_blown_out_stays_unless_the_board_is_baked():
    wet = gap(blow_off_um=80.0, dry_s=600.0)
    assert one(judge_part(evidence((wet,))), "R12").verdict == "marginal"
    for minutes, left in ((5.0, True), (20.0, False)):
        baked = PARAMETERS.drying.model_copy(update={"bake_c": 110.0, "bake_min": minutes})
        judged = judge_part(evidence((wet,), PARAMETERS.model_copy(update={"drying": baked})))
        assert (one(judged, "R12").verdict == "marginal") == left


def test_fast_flow_is_judged_at_its_bound_and_says_so():
    fast = one(judge_part(evidence((gap(wash={"reynolds": 18.0}),))), "R7")
    assert fast.verdict == "clean"
    assert "reduced Reynolds number of 18 (a thin gap: 10 at most)" in fast.because
    assert "Reynolds" not in one(judge_part(evidence((gap(wash={"reynolds": 9.9}),))), "R7").because


def test_what_is_no_thin_gap_has_no_verdict():
    judged = judge_part(evidence((gap(gap_height_mm=0.4),)))
    assert one(judged, "R14").verdict == "no verdict"
    assert "R7" not in rules(judged)


def test_the_harder_of_two_bounds_decides_and_the_other_is_told():
    judged = one(judge_part(evidence((gap(residue=0.3), gap(residue=0.01, gap_height_mm=0.075)))), "R7")
    assert judged.verdict == "dirty"
    assert "75 µm, it is clean" in judged.because


def test_the_higher_bound_decides_where_it_comes_out_worse():
    judged = one(judge_part(evidence((gap(residue=0.01), gap(residue=0.1, gap_height_mm=0.075)))), "R7")
    assert judged.verdict == "marginal"
    assert "in a gap of 75 µm" in judged.because
    assert "At the other bound, a standoff of 50 µm, it is clean." in judged.because
    known = with_limits(ionic_ug_cm2=0.2)
    ionic = judge_part(evidence((gap(), gap(ionic_ug_cm2=0.3, gap_height_mm=0.15)), known))
    assert one(ionic, "R11").verdict == "dirty"
    assert "50 µm, it is clean" in one(ionic, "R11").because


def test_rules_that_a_dry_gap_is_not_asked_are_not_said_of_the_other_bound():
    dry = gap(wash={"margin_pa": -120.0, "entered": False}, residue=1.0)
    judged = judge_part(evidence((dry, gap(residue=0.1, gap_height_mm=0.075))))
    assert one(judged, "R4").verdict == "dirty"
    assert "75 µm, it is marginal" in one(judged, "R4").because
    assert "R7" not in rules(judged)
    turned = judge_part(evidence((gap(residue=0.1), replace(dry, gap_height_mm=0.075))))
    assert one(turned, "R4").verdict == "dirty"
    assert "50 µm, it is marginal" in one(turned, "R4").because
    assert "R7" not in rules(turned)


def test_a_higher_bound_that_is_no_thin_gap_is_said():
    judged = judge_part(evidence((gap(), gap(gap_height_mm=0.4))))
    assert {each.verdict for each in judged} == {"clean"}
    assert "a standoff of 400 µm, it is no thin gap" in one(judged, "R7").because
    both = judge_part(evidence((gap(gap_height_mm=0.3), gap(gap_height_mm=0.4))))
    assert one(both, "R14").verdict == "no verdict"


def test_a_clean_part_is_as_sure_as_the_least_sure_of_what_makes_it_clean():
    judged = judge_part(evidence((gap(),)))
    assert {(each.rule.id, each.grade) for each in judged} == {("R2", "C"), ("R7", "C")}
    assert judged[0].grade == "C"
    shown = {f"limits.{use}_volume_mm": Provenance(known="source", source="a document") for use in ("wash", "rinse")}
    stated = PARAMETERS.model_copy(update={"provenance": {**PARAMETERS.provenance, **shown}})
    surer = judge_part(evidence((gap(),), stated))
    assert {each.grade for each in surer if each.rule.id == "R2"} == {"B"}
    assert (surer[0].rule.id, surer[0].grade) == ("R7", "C")
    assert judge_part(evidence())[0].grade == "C"


def test_what_shows_nothing_and_has_no_gap_is_not_judged():
    nothing = exposed(area=0.0)
    judged = judge_part(evidence(exposed=(nothing,) * 3, reached=(Reach("wash", "clean", "sequence[0]", 1, nothing),)))
    assert [(each.rule.id, each.verdict) for each in judged] == [("R14", "no verdict")]


def test_the_process_is_judged_by_bath_water_and_temperature():
    assert judge_process([stage("wash"), stage("rinse"), stage("dry")], PARAMETERS) == []
    used = stage("wash", liquid=stage("wash").liquid.model_copy(update={"bath_nvr_pct": 4.0}))
    assert rules(judge_process([used, stage("rinse")], PARAMETERS)) == ["R9"]
    for resistivity, verdict in ((0.1, "marginal"), (0.04, "dirty")):
        tap = stage("rinse", liquid=stage("rinse").liquid.model_copy(update={"resistivity_mohm_cm": resistivity}))
        assert [each.verdict for each in judge_process([tap], PARAMETERS)] == [verdict]
    assert rules(judge_process([stage("wash", temperature_c=85.0), stage("rinse")], PARAMETERS)) == ["R13"]
    assert rules(judge_process([stage("wash")], PARAMETERS)) == ["R10"]


@pytest.mark.parametrize(("age", "most", "late"), [(30.0, 24.0, True), (20.0, 24.0, False), (None, 24.0, False)])
def test_residue_that_is_older_than_it_may_be_is_said(age, most, late):
    known = with_limits(hours_after_reflow=most)
    known = known.model_copy(update={"soil": known.soil.model_copy(update={"age_h": age})})
    assert (rules(judge_process([stage("wash"), stage("rinse")], known)) == ["R13"]) == late


@pytest.mark.slow
@settings(max_examples=60)
@given(
    residue=st.floats(0, 1), worse=st.floats(0, 1), low=st.floats(0, 50), missed=st.floats(0, 1), n=st.floats(0, 100)
)
def test_more_residue_less_liquid_and_fewer_exchanges_never_judge_better(residue, worse, low, missed, n):
    def rank(share, amount, gone, times):
        seen = exposed(missed=gone, low=amount)
        reached = (Reach("wash", "clean", "sequence[0]", 1, seen),)
        part = evidence((gap(residue=share, residue_worst=share, wash={"exchanges": times}),), reached=reached)
        return VERDICTS.index(judge_part(part)[0].verdict)

    first = rank(residue, low, missed, n)
    assert rank(max(residue, worse), low, missed, n) <= first
    assert rank(residue, low * worse, missed, n) <= first
    assert rank(residue, low, max(missed, worse), n) <= first
    assert rank(residue, low, missed, n * worse) <= first


@pytest.mark.parametrize(
    ("residue", "worst", "says"),
    [
        (0.996, 1.0, "100 % of the residue is left under it, in a gap of 50 µm; in its worst tenth 100 %."),
        (0.0719, 0.234, "7.2 % of the residue is left under it, in a gap of 50 µm; in its worst tenth 23 %."),
        (0.00067, 0.0, "0.067 % of the residue is left under it, in a gap of 50 µm; in its worst tenth 0 %."),
        (2e-9, 3e-5, "less than 0.01 % of the residue is left under it, in a gap of 50 µm; in its worst tenth less "),
    ],
)
def test_residue_is_written_as_a_person_writes_percent(residue, worst, says):
    assert says in one(judge_part(evidence((gap(residue=residue, residue_worst=worst),))), "R7").because


def test_what_a_part_does_not_bear_has_the_grade_of_its_rule():
    grades = {rule.id: rule.grade for rule in RULES}
    judged = judge_part(evidence(override=PartOverride(match=["U1"], most_kpa=0.2, window_c=(0, 50))))
    found = {each.rule.id: each.grade for each in judged if each.verdict == "dirty"}
    assert found == {"R3": grades["R3"], "R13": grades["R13"]}


@pytest.mark.parametrize(
    ("known", "grade"),
    [("proposed", "C"), ("synthetic", "C"), ("literature", "B"), ("source", "B"), ("calibrated", "B")],
)
def test_too_little_is_as_sure_as_the_limit_it_is_compared_with(known, grade):
    source = Provenance(known=known, source="a document")
    stated = PARAMETERS.model_copy(update={"provenance": {**PARAMETERS.provenance, "limits.wash_volume_mm": source}})
    little = replace(washed(low=0.1), parameters=stated)
    judged = one(judge_part(little), "R2")
    assert (judged.verdict, judged.grade) == ("dirty", grade)


def test_the_least_sure_of_the_limits_counts_and_only_never_hit_has_grade_a():
    source = Provenance(known="source", source="a document")
    stated = with_limits(front_s=5.0)
    stated = stated.model_copy(update={"provenance": {**stated.provenance, "limits.wash_volume_mm": source}})
    assert one(judge_part(replace(washed(front=0.1), parameters=stated)), "R2").grade == "C"
    assert one(judge_part(washed(missed=0.3)), "R1").grade == "A"

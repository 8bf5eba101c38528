import json
from dataclasses import replace

from cleaning_report import small_report

from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Provenance
from cleaning.report import Traceability, cleaning_report
from cleaning.verify import Verified
from specs.source import Source


def test_the_same_report_gives_the_same_text_and_it_is_json():
    texts = [json.dumps(cleaning_report(small_report()), allow_nan=False) for _ in range(2)]
    assert texts[0] == texts[1]
    assert json.loads(texts[0])["washboard_cleaning_report"] == 1


def test_every_component_is_there_with_its_verdict_and_the_numbers_behind_it():
    report = small_report()
    told = json.loads(json.dumps(cleaning_report(report)))
    assert [each["component"] for each in told["components"]] == [part.component for part in report.parts]
    assert told["worst_first"][0] == "U1"
    assert sum(told["verdicts"].values()) == len(report.parts)
    decisive = told["components"][0]["judgements"][0]
    assert (decisive["rule"], decisive["verdict"], decisive["grade"]) == ("R7", "dirty", "C")
    assert told["components"][0]["uncalibrated"] is True
    assert decisive["numbers"][0] == {"name": "residue", "value": 31.0, "unit": "%", "limit": 20.0}


def test_a_gap_whose_standoff_is_not_known_is_told_for_both_bounds():
    u1 = cleaning_report(small_report())["components"][0]
    assert [gap["standoff_mm"] for gap in u1["gaps"]] == [0.05, 0.075]
    assert all(len(gap["stages"]) == 2 and len(gap["stages"][0]["edge_pa"]) == 8 for gap in u1["gaps"])


def test_a_stage_that_does_not_act_is_null():
    report = small_report()
    first = report.parts[0]
    gaps = tuple(replace(gap, stages=(gap.stages[0], None)) for gap in first.gaps)
    part = replace(first, gaps=gaps, exposed=(first.exposed[0], None))
    told = cleaning_report(replace(report, parts=(part, *report.parts[1:])))["components"][0]
    assert told["exposed"][1] is None
    assert told["gaps"][0]["stages"][1] is None


def test_what_has_no_bound_is_null_because_json_has_no_infinity():
    report = small_report()
    gap = replace(report.parts[0].gaps[0], exchanges_needed=float("inf"))
    part = replace(report.parts[0], gaps=(gap,))
    text = json.dumps(cleaning_report(replace(report, parts=(part,))), allow_nan=False)
    assert json.loads(text)["components"][0]["gaps"][0]["exchanges_needed"] is None


def test_what_was_computed_exactly_names_the_step_of_the_recipe():
    step = Source.parse("sequence[0]")
    both = Verified(
        "U1",
        "clean",
        step,
        rays_mm=1.0,
        exact_mm=1.23456789,
        worst_mm=0.5,
        cells=7,
        cone_s=3.0,
        cone_error_s=0.1,
        exact_cone_s=3.05,
    )
    (found,) = json.loads(json.dumps(cleaning_report(small_report(), [both])))["verified"]
    assert found == {
        "component": "U1", "function": "clean", "made_by": "sequence[0]", "rays_mm": 1.0, "exact_mm": 1.23457,
        "worst_mm": 0.5, "cells": 7, "cone_s": 3.0, "cone_error_s": 0.1, "exact_cone_s": 3.05,
    }  # fmt: skip


def test_what_was_entered_and_which_program_it_is_about_are_in_the_data():
    told = cleaning_report(small_report(), trace=Traceability(serial="SN 42", program_sha256="ab" * 32))
    assert told["traceability"]["serial"] == "SN 42"
    assert told["traceability"]["program_sha256"] == "ab" * 32
    assert told["traceability"]["detergent"] == ""


def test_a_fitted_value_is_told_with_what_it_was_fitted_to():
    entry = Provenance(
        known="calibrated", source="coupons.csv", date="2026-11-21", samples=48, rms=0.0164, interval=(0.01, 0.014)
    )
    provenance = {**load_parameters().provenance, "soil.k1_per_s": entry}
    parameters = small_report().parameters.model_copy(update={"provenance": provenance})
    told = cleaning_report(replace(small_report(), parameters=parameters))["assumptions"]
    k1 = next(each for each in told if each["path"] == "soil.k1_per_s")
    assert (k1["known"], k1["date"], k1["samples"], k1["rms"]) == ("calibrated", "2026-11-21", 48, 0.0164)
    assert k1["interval"] == [0.01, 0.014]
    assert next(each for each in told if each["path"] == "soil.retained")["samples"] is None


def test_a_component_has_the_residue_of_its_worse_gap():
    u1, *_, j1 = cleaning_report(small_report())["components"]
    assert u1["residue"] == max(gap["residue"] for gap in u1["gaps"])
    assert (j1["residue"] is None) == (not j1["gaps"])

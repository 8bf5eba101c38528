from dataclasses import replace

import pytest
from cleaning_report import small_report

from cleaning.report import cleaning_report
from reports.html.cleaning_page import comparison_page
from reports.tables.comparison import Row, compare_cleaning, comparison_data

NAMES = ("smt-aqueous", "other & better")


def other():
    report = small_report()
    u1 = next(part for part in report.parts if part.component == "U1")
    clean = replace(u1, verdict="clean", judgements=u1.judgements[2:])
    parts = tuple(clean if part is u1 else part for part in report.parts)
    origin = replace(report.origin, recipe="other & better")
    return replace(report, origin=origin, parts=parts, verdict="marginal")


@pytest.mark.slow
def test_both_are_on_the_page_with_what_differs_and_what_it_is_worth():
    rows = compare_cleaning(small_report(), other())
    page = comparison_page(rows, (small_report(), other()), NAMES)
    assert "other &amp; better" in page
    assert "Predicted: 1 of 5 components dirty" in page
    assert "Predicted: 1 of 5 components marginal" in page
    assert "uncalibrated" in page
    assert page.count("data:image/svg+xml") == 2
    assert page == comparison_page(rows, (small_report(), other()), NAMES)
    assert page.count("</span>clean, wet") == 2, "each picture has its legend"
    assert small_report().origin.board_sha256 in page


def test_names_cannot_become_markup():
    page = comparison_page([Row("Liquid", "<b>x", "<i>", "2")], (small_report(), other()), ("<b>x", "<i>y"))
    assert "<b>x" not in page
    assert "<i>" not in page


def test_the_data_has_every_component_with_both_verdicts():
    here, there = small_report(), other()
    told = comparison_data(compare_cleaning(here, there), here, there)
    first = next(each for each in told["components"] if each["component"] == "U1")
    assert [each["verdict"] for each in first["reports"]] == ["dirty", "clean"]
    assert [each["residue"] for each in first["reports"]] == [0.31, 0.31]
    assert len(told["components"]) == len(here.parts)


def test_the_data_of_each_is_that_of_its_own_report():
    here, there = small_report(), other()
    told = comparison_data([], here, there)
    for summary, report, place in zip(told["reports"], (here, there), (0, 1), strict=True):
        whole = cleaning_report(report)
        assert summary.items() <= whole.items()
        for component in told["components"]:
            own = next(each for each in whole["components"] if each["component"] == component["component"])
            assert component["reports"][place].items() <= own.items()


def test_a_component_of_one_alone_is_null_in_the_other():
    here = small_report()
    there = replace(here, parts=tuple(part for part in here.parts if part.component != "U1"))
    told = comparison_data([], here, there)["components"]
    assert next(each for each in told if each["component"] == "U1")["reports"][1] is None

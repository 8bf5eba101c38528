from dataclasses import replace

from cleaning_report import small_report

from rulesengine.comparison import Row, compare_cleaning, comparison_data
from rulesengine.comparison_page import comparison_page


def other():
    report = small_report()
    clean = replace(report.parts[0], verdict="clean", judgements=report.parts[0].judgements[2:])
    origin = replace(report.origin, recipe="other & better")
    return replace(report, origin=origin, parts=(clean, *report.parts[1:]), verdict="marginal")


def test_both_are_on_the_page_with_what_differs_and_what_it_is_worth():
    rows = compare_cleaning(small_report(), other())
    page = comparison_page(rows, small_report(), other())
    assert "other &amp; better" in page
    assert "Predicted: 1 of 5 components dirty" in page
    assert "Predicted: 1 of 5 components marginal" in page
    assert "uncalibrated" in page
    assert page.count("data:image/svg+xml") == 2
    assert page == comparison_page(rows, small_report(), other())


def test_names_cannot_become_markup():
    page = comparison_page([Row("Liquid", "<b>x", "<i>", "2")], small_report(), other())
    assert "<b>x" not in page
    assert "<i>" not in page


def test_the_data_has_every_component_with_both_verdicts():
    here, there = small_report(), other()
    told = comparison_data(compare_cleaning(here, there), here, there)
    first = next(each for each in told["components"] if each["component"] == "U1")
    assert first["verdicts"] == ["dirty", "clean"]
    assert first["residues"] == [0.31, 0.31]
    assert len(told["components"]) == len(here.parts)

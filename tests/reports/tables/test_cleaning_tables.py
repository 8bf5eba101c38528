from dataclasses import replace
from pathlib import Path
from typing import get_args

from cleaning_report import small_report

from cleaning.parameters.model import Known
from cleaning.verdicts.rules import Grade, Verdict
from reports.tables.cleaning_tables import GRADES, KNOWN_WORDS, LIMITS, VERDICT_WORDS, main_cause

PAGE = (Path(__file__).parents[3] / "docs" / "cleaning.md").read_text("utf-8")


def test_the_document_has_the_same_grades_and_limits_as_the_report() -> None:
    for grade, words in GRADES.items():
        assert f"| {grade} | {words} |" in PAGE
    told = " ".join(PAGE.split())
    assert all(text in told for text in LIMITS)


def test_nothing_is_left_without_words() -> None:
    assert set(GRADES) == set(get_args(Grade))
    assert set(VERDICT_WORDS) == set(get_args(Verdict))
    assert set(KNOWN_WORDS) == set(get_args(Known))


def test_no_word_claims_that_a_standard_is_met() -> None:
    assert not any(word in PAGE for word in ("J-STD", "IPC-", "passed"))


def test_one_sentence_names_what_most_components_fail_by() -> None:
    report = small_report()  # U1 is dirty by R7, R1 marginal by R8
    assert main_cause(report).startswith("1 of 2 that are not clean fail by R7 residue")
    first = report.parts[0]
    more = replace(report, parts=(first, replace(first, component="U2"), *report.parts[1:]))
    assert main_cause(more).startswith("2 of 3 that are not clean fail by R7 residue")
    assert main_cause(more).endswith(first.judgements[0].advice)
    clean = tuple(part for part in report.parts if part.verdict == "clean")
    assert main_cause(replace(report, parts=clean)) == ""

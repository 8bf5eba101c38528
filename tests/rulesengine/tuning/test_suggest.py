"""Advice that names key and value."""

from cleaning_report import small_report
from tiny_session import tiny_session

from cleaning.verdicts.cleanliness import deciding_judgement
from cleaning.verdicts.rules import RESIDUE_LEFT
from rulesengine.tuning.suggest import advise, suggest


def test_the_advice_of_what_decides_names_the_edit_that_is_expected_to_help_most():
    run, report = tiny_session().run, small_report()
    advised = advise(report, run.program, run.recipe)
    best = next(each for each in suggest(run, report) if each.component == "U1")
    before, after = deciding_judgement(report.parts[0]), deciding_judgement(advised.parts[0])
    assert before.rule == RESIDUE_LEFT
    assert after.advice == f"{before.advice} For example {best.what}."
    assert " -> " in best.what
    assert [each.rule for each in advised.parts[0].judgements] == [each.rule for each in report.parts[0].judgements]


def test_what_is_clean_or_cannot_be_met_is_left_as_it_is():
    run, report = tiny_session().run, small_report()
    advised = advise(report, run.program, run.recipe)
    for before, after in zip(report.parts, advised.parts, strict=True):
        if before.verdict in ("clean", "no verdict"):
            assert after == before

"""Advice that names key and value."""

from cleaning_report import small_report
from tiny_session import tiny_session

from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from cleaning.verdicts.results import deciding_judgement
from cleaning.verdicts.rules import RESIDUE_LEFT
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run
from rulesengine.tuning.report import advise, suggest
from specs.progress import no_progress


def test_the_advice_of_what_decides_names_the_edit_that_is_expected_to_help_most():
    planned, report = tiny_session().run, small_report()
    advised = advise(report, planned.program, planned.recipe)
    best = next(each for each in suggest(planned, report) if each.component == "U1")
    sensor, later = (next(part for part in each.parts if part.component == "U1") for each in (report, advised))
    before, after = deciding_judgement(sensor), deciding_judgement(later)
    assert before.rule == RESIDUE_LEFT
    assert after.advice == f"{before.advice} For example {best.what}."
    assert " -> " in best.what
    assert [each.rule for each in later.judgements] == [each.rule for each in sensor.judgements]


def test_what_is_clean_or_cannot_be_met_is_left_as_it_is():
    planned, report = tiny_session().run, small_report()
    advised = advise(report, planned.program, planned.recipe)
    for before, after in zip(report.parts, advised.parts, strict=True):
        if before.verdict in ("clean", "no verdict"):
            assert after == before


def test_a_program_that_only_dries_is_advised_though_not_even_the_bare_board_is_sprayed():
    session = tiny_session()
    done = run(load_recipe("dry-only"), session.board)
    prepared = prepare(session.board, load_parameters(), no_progress)
    report = analyse_on(prepared, done.program, done.recipe, "sketch", sensitivity=False)
    assert any(each.name == "not sprayed" for each in report.bare.judgements)
    assert len(advise(report, done.program, done.recipe).parts) == len(report.parts)

from dataclasses import replace
from pathlib import Path

import pytest
from cleaning_report import small_report

from boards.load import load_board
from cleaning.verdicts.results import Judgement
from cleaning.verdicts.rules import WET_GAP
from recipes.load import load_recipe
from reports.tables.comparison import compare, compare_cleaning
from rulesengine.planning.pipeline import run
from rulesengine.planning.spray_runs import sprayed_in


@pytest.fixture(scope="module")
def rinsed():
    return run(load_recipe("rinse-only"), load_board(Path("tiny")))


def test_what_is_sprayed_in_one_go_holds_all_passes_and_pauses(rinsed):
    from programs.plan import Dwell, SprayPass

    told = sprayed_in(rinsed.plan)
    items = rinsed.plan.items
    assert sum(len(each.passes) for each in told) == sum(isinstance(item, SprayPass) for item in items)
    assert sum(len(each.pauses) for each in told) == sum(isinstance(item, Dwell) for item in items)
    assert all(str(one.made_by) == str(each.made_by) for each in told for one in each.passes)
    assert sum(each.way_mm for each in told) > 100


def test_a_run_does_not_differ_from_itself(rinsed):
    assert not any(row.differs or row.change for row in compare(rinsed, rinsed))


def better():
    """The small report with U1 clean and nothing left under it."""
    report = small_report()
    u1 = report.parts[0]
    gaps = tuple(replace(gap, residue=0.001) for gap in u1.gaps)
    good = tuple(each for each in u1.judgements if each.verdict == "clean")
    parts = (replace(u1, verdict="clean", judgements=good, gaps=gaps), *report.parts[1:])
    return replace(report, parts=parts, verdict="marginal")


def test_reports_are_compared_by_verdict_and_worst_residue():
    rows = {row.name: (row.here, row.there) for row in compare_cleaning(small_report(), better())}
    assert rows["Predicted verdict"] == ("dirty", "marginal")
    assert rows["Components dirty"] == ("1", "0")
    assert rows["Components clean"] == ("2", "3")
    assert rows["Worst residue under a part"] == ("31 % (U1)", "4 % (R1)")
    assert rows["U1"] == ("dirty", "clean")
    assert rows["Bare board"] == ("clean", "clean")
    assert "R1" not in rows, "its verdict is the same"


def test_what_is_clean_and_stays_wet_is_told_apart_from_what_is_dirty():
    report = small_report()
    last = report.parts[-1]
    wet = Judgement(rule=WET_GAP, verdict="marginal", because="Water stays under it.", advice="Bake it.")
    dripping = replace(report, parts=(*report.parts[:-1], replace(last, judgements=(wet, *last.judgements))))
    rows = {row.name: (row.here, row.there) for row in compare_cleaning(report, dripping)}
    assert rows["Components that stay wet underneath"] == ("0", "1")
    assert rows["Components clean"][0] == rows["Components clean"][1]
    assert rows[last.component][1] == f"{rows[last.component][0]}, wet"


def test_a_report_does_not_differ_from_itself():
    rows = compare_cleaning(small_report(), small_report())
    assert not any(row.differs for row in rows)
    assert all(row.group == "Cleaning" for row in rows)


def test_without_gaps_there_is_no_residue():
    report = small_report()
    bare = replace(report, parts=tuple(replace(part, gaps=()) for part in report.parts))
    rows = {row.name: row for row in compare_cleaning(report, bare)}
    assert rows["Worst residue under a part"].there == "none"


def test_residue_that_is_next_to_nothing_is_said_to_be_that():
    report = small_report()
    rinsed = tuple(replace(part, gaps=tuple(replace(gap, residue=2e-9) for gap in part.gaps)) for part in report.parts)
    rows = {row.name: row for row in compare_cleaning(report, replace(report, parts=rinsed))}
    assert rows["Worst residue under a part"].there.startswith("under 0.01 % (")

"""Tables of a study are read as they were written; what is no such table is refused with its line."""

from pathlib import Path

import pytest
from made_study import PATHS, SPEEDS, write_made_study

from specs.progress import no_progress
from studies.errors import StudyError
from studies.results.read_tables import begins_runs, read_tables
from studies.results.summary import wilson


def test_a_study_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_made_study(tmp_path, boards=("tiny", "two-sided"), failing=frozenset({3}))
    found = read_tables(tmp_path / "runs.csv", no_progress)
    assert (found.paths, found.boards) == (PATHS, ("tiny", "two-sided"))
    assert [each.number for each in found.combinations] == list(range(1, 17))
    first, failed = found.combinations[0], found.combinations[2]
    assert (first.board, first.recipe, first.parameters, first.point) == (
        "tiny",
        "smt-aqueous",
        "default",
        ("40", "300"),
    )
    assert (first.seconds, first.litres) == (300 + 6000 / 40 + 28, (300 + 6000 / 40 + 28) / 27)
    assert (first.clean, first.components, first.verdicts["dirty"]) == (5, 5, 0)
    assert (first.all_clean, first.samples) == (2, 4)  # of four boards with deviations every other one lacks U5
    assert [each.component for each in first.shares] == ["U1", "U2", "U3", "U4", "U5"]
    assert (first.shares[4].share, first.shares[4].interval) == (0.5, wilson(2, 4))
    assert (failed.error, failed.components, failed.pareto, failed.samples) == ("too fast", 0, False, 0)
    assert any(each.pareto for each in found.combinations)
    levels = {(each.factor, each.level): each.runs for each in found.effects}
    assert levels[PATHS[0], str(SPEEDS[0])] == 4
    assert levels["board", "tiny"] == 7


def test_runs_by_themselves_are_enough(tmp_path: Path) -> None:
    write_made_study(tmp_path / "study", samples=0)
    whole = read_tables(tmp_path / "study" / "runs.csv", no_progress)
    assert [each.shares for each in whole.combinations] == [()] * 8
    assert whole.effects
    alone = (tmp_path / "study" / "runs.csv").rename(tmp_path / "study" / "speeds.csv")
    read = read_tables(alone, no_progress)
    assert (read.combinations, read.effects) == (whole.combinations, ())


def test_a_table_of_runs_is_known_by_its_head(tmp_path: Path) -> None:
    write_made_study(tmp_path)
    kinds = {name: begins_runs((tmp_path / f"{name}.csv").read_bytes()) for name in ("runs", "components", "effects")}
    assert kinds == {"runs": True, "components": False, "effects": False}
    assert not begins_runs(b"")
    assert not begins_runs(b"case,board,recipe,parameters\xff\n")


HEAD = "case,board,recipe,parameters,sample,seconds,litres,clean,marginal,dirty,no_verdict,components,pareto,error\n"
GOOD = "1,tiny,own,default,0,10.0,1.5,1,0,1,0,2,True,\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no such table of a study: it has no column case"),
        (HEAD.replace("litres", "water"), "it has no column litres"),
        (HEAD + GOOD + GOOD.replace("1.5", "inf"), r"runs\.csv:3: litres: 'inf' is no number"),
        (HEAD + GOOD.replace("10.0", "soon"), r"runs\.csv:2: seconds: 'soon' is no number"),
        (HEAD + GOOD.replace(",1,0,1,", ",-1,0,1,"), r"runs\.csv:2: clean: -1 counts nothing"),
        (HEAD + "1,tiny\n", r"runs\.csv:2: 2 cells; the header has 14"),
        (HEAD + GOOD.replace(",0,10.0", ",1,10.0"), r"runs\.csv:2: case: its run as planned is not above it"),
        (HEAD.replace("pareto", "front") + GOOD, r"runs\.csv:2: pareto: the column is missing"),
        (HEAD + GOOD.replace("own", "x" * 200_000), r"runs\.csv:2: field larger than field limit"),
    ],
)
def test_what_is_no_table_of_runs_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "runs.csv").write_text(text)
    with pytest.raises(StudyError, match=message):
        read_tables(tmp_path / "runs.csv", no_progress)


def test_shares_of_more_than_all_samples_are_refused(tmp_path: Path) -> None:
    (tmp_path / "runs.csv").write_text(HEAD + GOOD)
    (tmp_path / "components.csv").write_text("case,component,as_planned,samples,clean\n1,U1,clean,4,5\n")
    with pytest.raises(StudyError, match=r"components\.csv:2: clean: 5 of 4 samples is no share"):
        read_tables(tmp_path / "runs.csv", no_progress)

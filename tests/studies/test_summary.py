"""Summaries against numbers by hand: main effects, Pareto fronts, intervals; tables that read back."""

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest

from studies.errors import StudyError
from studies.job import Input, JobResult
from studies.planned_study import PlannedStudy
from studies.results.page import draw_study, study_page
from studies.results.summary import Level, Run, Summary, pareto_front, runs_of, summarise, wilson
from studies.results.tables import components_table, csv_bytes, effects_table, parquet_bytes, runs_table
from studies.store import ResultStore
from studies.study import Study, design_points, draw_deviations

BOARD, SET = Input("tiny", "/tiny.tri", "b"), Input("default", "/default.yaml", "p")
RECIPES = Input("one", "/one.yaml", "1"), Input("two", "/two.yaml", "2")


def planned(**keys: Any) -> PlannedStudy:
    stated = {"study": "x", "boards": ["tiny"], "recipes": ["one", "two"], **keys}
    study = Study.model_validate(stated)
    points, deviations = tuple(design_points(study)), tuple(draw_deviations(study.tolerances))
    paths = tuple(tuple(each.path.split(".")) for each in study.variables)
    own = ((None,) * len(paths),) * 2
    return PlannedStudy(study, (BOARD,), RECIPES, (SET,), None, paths, own, points, deviations)


def clean(count: int, of: int) -> dict[str, str]:
    return {f"U{number}": "clean" if number <= count else "dirty" for number in range(1, of + 1)}


def by_hand(values: dict[tuple[str, Any], tuple[float, float, int]]) -> tuple[PlannedStudy, list[Run]]:
    """Two recipes by two speeds, with seconds, litres and clean components of 4."""
    study = planned(variables=[{"path": "t.speed", "values": [40, 80]}])
    runs: list[Run] = []
    for case in study.cases():
        seconds, litres, count = values[case.recipe.name, case.point[0]]
        runs.append(Run(case, 0, (), JobResult("k", "", seconds, litres, "dirty", clean(count, 4))))
    return study, runs


VALUES = {
    ("one", 40): (100.0, 4.0, 4), ("one", 80): (60.0, 3.0, 2),
    ("two", 40): (140.0, 8.0, 4), ("two", 80): (100.0, 5.0, 2),
}  # fmt: skip


@pytest.mark.parametrize(
    ("kept", "message"), [(None, r"no such file; start the study again"), (b"[]", "is not the result that was kept")]
)
def test_a_result_that_cannot_be_read_is_named(kept: bytes | None, message: str, tmp_path: Path) -> None:
    study, store = planned(), ResultStore(tmp_path)
    job = next(study.jobs())
    if kept is not None:
        store.keep(JobResult(job.key))
        next(tmp_path.rglob("*.json")).write_bytes(kept)
    assert store.find(job.key) is None
    with pytest.raises(StudyError, match=rf"results/{job.key[:2]}/{job.key}\.json: {message}"):
        next(runs_of(study, store))


def test_main_effects_by_hand() -> None:
    study, runs = by_hand(VALUES)
    effects = {(each.factor, each.level): each for each in summarise(study, iter(runs)).effects}
    # All runs: 100 s, 5 l, 3 of 4 clean.
    assert effects == {
        ("recipe", "one"): Level("recipe", "one", 2, 80.0, 3.5, 75.0, -20.0, -1.5, 0.0),
        ("recipe", "two"): Level("recipe", "two", 2, 120.0, 6.5, 75.0, 20.0, 1.5, 0.0),
        ("t.speed", "40"): Level("t.speed", "40", 2, 120.0, 6.0, 100.0, 20.0, 1.0, 25.0),
        ("t.speed", "80"): Level("t.speed", "80", 2, 80.0, 4.0, 50.0, -20.0, -1.0, -25.0),
    }


def test_the_front_has_what_nothing_is_better_than() -> None:
    study, runs = by_hand(VALUES)
    found = summarise(study, iter(runs))
    assert [each.planned.case.number for each in found.fronts["tiny"]] == [2, 1]  # of "two" both are worse
    equal = [replace(each, planned=runs[0]) for each in found.cases]
    assert len(pareto_front(equal)) == 1


def test_a_combination_that_bears_the_tolerances_better_is_on_the_front() -> None:
    study = planned(
        variables=[{"path": "t.seconds", "values": [300, 330, 360]}],
        tolerances={"samples": 4, "deviations": {"pressure_pct": {"distribution": "uniform", "low": -9, "high": 9}}},
        recipes=["one"],
    )
    often = {300: 2, 330: 4, 360: 4}
    runs: list[Run] = []
    for case in replace(study, recipes=RECIPES[:1]).cases():
        for sample, deviation in enumerate(((), *study.deviations)):
            count = 2 if sample <= often[int(case.point[0])] else 1
            result = JobResult("k", "", float(case.point[0]), 1.0, "clean", clean(count, 2))
            runs.append(Run(case, sample, deviation, result))
    front = summarise(study, iter(runs)).fronts["tiny"]
    assert [each.planned.case.point for each in front] == [(300,), (330,)]


def test_an_error_is_counted_and_changes_no_mean() -> None:
    study, runs = by_hand(VALUES)
    runs[3] = replace(runs[3], result=JobResult("k", error="refused"))
    found = summarise(study, iter(runs))
    assert found.failed == 1
    assert {each.level: each.seconds for each in found.effects if each.factor == "recipe"} == {
        "one": 80.0,
        "two": 140.0,
    }
    table = runs_table(study, found, runs)
    assert (table["seconds"][3], table["error"][3]) == (None, "refused")


def tolerated() -> tuple[PlannedStudy, list[Run], Summary]:
    """Clean in 3 of 6 boards: where the standoff is small."""
    deviations = {"standoff_mm": {"distribution": "uniform", "low": -3, "high": 3}}
    study = planned(tolerances={"samples": 6, "deviations": deviations})
    runs: list[Run] = []
    for case in study.cases():
        for sample, deviation in enumerate(((), *study.deviations)):
            count = 2 if not deviation or deviation[0][1] < 0 else 1
            result = JobResult("k", "", 10.0, 1.0, "dirty", clean(count, 2))
            runs.append(Run(case, sample, deviation, result))
    return study, runs, summarise(study, iter(runs))


def test_how_often_each_component_is_clean_by_hand() -> None:
    _, _, found = tolerated()
    case = found.cases[0]
    assert [(each.component, each.clean, each.samples) for each in case.shares] == [("U1", 6, 6), ("U2", 3, 6)]
    assert (case.all_clean, case.samples) == (3, 6)
    # Wilson for 3 of 6: (1/2 + z²/12 ± z sqrt(1/24 + z²/144)) / (1 + z²/6), z = 1.96.
    assert case.shares[1].interval == pytest.approx((0.18761, 0.81239), abs=1e-5)
    assert wilson(6, 6)[1] == 1.0
    assert wilson(0, 6)[0] == 0.0


def test_a_deviation_acts_by_its_thirds() -> None:
    _, _, found = tolerated()
    levels = [each for each in found.effects if each.factor == "standoff_mm"]
    assert [each.runs for each in levels] == [4, 4, 4]  # six boards with each of two recipes
    assert [each.clean_pct for each in levels] == [100.0, 75.0, 50.0]
    assert [each.clean_pct_effect for each in levels] == [25.0, 0.0, -25.0]


def test_tables_read_back_as_they_were() -> None:
    study, runs, found = tolerated()
    for table in (runs_table(study, found, runs), components_table(study, found), effects_table(found)):
        rows = list(csv.reader(io.StringIO(csv_bytes(table).decode())))
        assert rows[0] == list(table)
        assert [row[0] for row in rows[1:]] == [str(value) for value in next(iter(table.values()))]
        assert pyarrow.parquet.read_table(io.BytesIO(parquet_bytes(table))).to_pydict() == table
        assert parquet_bytes(table) == parquet_bytes(table)


def test_numbers_and_words_in_one_column_are_words_in_parquet() -> None:
    table = {"height": [40, "auto", None], "speed": [1, 2.5, None]}
    read = pyarrow.parquet.read_table(io.BytesIO(parquet_bytes(table))).to_pydict()
    assert read == {"height": ["40", "auto", None], "speed": [1.0, 2.5, None]}


def test_the_picture_is_the_same_bytes_again() -> None:
    study, runs = by_hand(VALUES)
    found = summarise(study, iter(runs))
    drawn = draw_study("x", found, ".svg")
    assert drawn == draw_study("x", found, ".svg")


def test_boards_without_components_are_drawn_too() -> None:
    study, runs = by_hand(VALUES)
    bare = [replace(run, result=replace(run.result, components={})) for run in runs]
    assert b"<svg" in draw_study("x", summarise(study, iter(bare)), ".svg")


@pytest.mark.slow
def test_the_page_has_fronts_shares_effects_and_errors() -> None:
    study, runs, found = tolerated()
    page = study_page(study, found)
    assert page == study_page(study, found)
    for text in ("2 combinations", "3 of 6", "50%", "19% to 81%", "standoff_mm", "data:image/svg+xml"):
        assert text in page
    assert "<td>U2</td>" in page
    assert "<td>U1</td>" not in page  # always clean
    assert "ended in an error" not in page
    failing = [replace(run, result=JobResult("k", error="<refused>")) for run in runs]
    page = study_page(study, summarise(study, iter(failing)))
    assert "&lt;refused&gt;" in page
    assert "No combination could be computed." in page

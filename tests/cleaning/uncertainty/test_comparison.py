"""Measured cleanliness against prediction: on 40 made-up parts, the figures once more by hand."""

import csv
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brief_recipe import BRIEF
from cleaning_report import small_report
from measured_sample import measured_table

from boards.load import load_board
from cleaning.analyse import analyse
from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters
from cleaning.parameters.provenance import with_values
from cleaning.report import cleaning_report
from cleaning.uncertainty.comparison import calibrate_command, compare_measured
from cleaning.uncertainty.measured_table import read_measured
from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import RESIDUE_LEFT, UNDER_EXPOSED
from rulesengine.planning.pipeline import run

HEAD = "component,method,value,unit,limit\n"


def mean_ranks(values):
    return np.array(
        [sum(other < each for other in values) + 0.5 * sum(other == each for other in values) for each in values]
    )


@pytest.fixture(scope="module")
def report():
    """80 parts, a short wash, and a limit in the middle of what it leaves: some clean, some not."""
    board = load_board(Path("sensor-hub"))
    parameters = with_values(load_parameters(), {"limits.gap_marginal": 0.366, "limits.gap_dirty": 0.6})
    return analyse(run(BRIEF, board).program, board, BRIEF, parameters, "sketch")


@pytest.fixture(scope="module")
def file(report, tmp_path_factory):
    path = tmp_path_factory.mktemp("measured") / "measured.csv"
    path.write_text(measured_table(report, parts=40, seed=20), "utf-8")
    return path


def compared(report, file):
    return compare_measured(report, read_measured(file, [*(part.component for part in report.parts), "board"]))


@pytest.mark.slow
def test_40_parts_by_hand(report, file):
    data = {each["component"]: each for each in cleaning_report(report)["components"]}
    rows = list(csv.DictReader(line for line in file.read_text("utf-8").splitlines() if not line.startswith("#")))
    assert len(rows) == 40
    failed = {row["component"]: float(row["value"]) > 20.0 for row in rows}
    clean = {name: data[name]["cleanliness"] == "clean" for name in failed if data[name]["cleanliness"] != "no verdict"}
    cells = [
        {name for name in clean if clean[name] == good and failed[name] == bad}
        for good, bad in ((True, False), (True, True), (False, False), (False, True))
    ]
    found = compared(report, file)
    confusion = found.confusion
    assert [set(each) for each in (
        confusion.clean_within, confusion.clean_beyond, confusion.unclean_within, confusion.unclean_beyond
    )] == cells  # fmt: skip
    assert all(cells), "every case is there, or the test shows nothing"
    assert confusion.hit_rate == pytest.approx((len(cells[0]) + len(cells[3])) / len(clean))
    assert found.table.synthetic
    assert found.not_measured == 40
    dirt = mean_ranks([float(row["value"]) for row in rows])
    residue = mean_ranks([report_residue(report, row["component"]) for row in rows])
    (correlation,) = found.correlations
    assert correlation.pairs == 40
    assert correlation.rho == pytest.approx(np.corrcoef(residue, dirt)[0, 1])
    assert 0.2 < correlation.rho < 0.95
    by_rule = {each.rule.id: each for each in found.rules}
    faults = {name for name in clean if {"dirty", "marginal"} & {
        each["verdict"] for each in data[name]["judgements"] if each["rule"] == "R7"
    }}  # fmt: skip
    assert set(by_rule["R7"].faults_wrong) == {name for name in faults if not failed[name]}
    assert set(by_rule["R7"].faults_right) == {name for name in faults if failed[name]}
    assert set(by_rule["R7"].clean_wrong) == cells[1]
    assert "R12" not in by_rule


def report_residue(report, name):
    return next(part.residue for part in report.parts if part.component == name)


@pytest.mark.parametrize("value", [1, 9])
def test_the_sign_of_the_errors(tmp_path, value):
    """U1 is predicted dirty by R7, C1 clean: a false alarm raises the rate of softening, an escape lowers it."""
    path = tmp_path / "m.csv"
    path.write_text(HEAD + ("U1,tear-off,1,%,5\n" if value == 1 else "C1,ic,9,ug/cm2,5\n"), "utf-8")
    report = small_report()
    offers = {each.rule.id: each for each in compared(report, path).recalibrations}
    if value == 1:
        assert offers["R7"].values == ("soil.k1_per_s",)
        assert offers["R7"].raise_values
        words = shlex.split(calibrate_command(offers["R7"], report, "my recipe.yaml", "default"))
        assert words[:4] == ["washboard", "calibrate", "gap", "COUPONS.csv"]
        assert words[words.index("--recipe") + 1] == "my recipe.yaml"
        assert words[words.index("--nozzle") + 1] == "ring60"
        assert words[words.index("--solution") + 1] == "saponifier-15"
        assert not calibrate_command(offers["R8"], report, "a", "b"), "no calibration fits a limit"
    else:
        assert offers["R2"].too_lenient == 1
        assert offers["R2"].raise_values
        assert offers["R2"].calibration == "ring"


def cleared(*numbers):
    """A clean part by R2 and R7, with a number and its limit for each."""
    (first, *_), report = small_report().parts, small_report()
    judgements = tuple(
        Judgement(rule=rule, verdict="clean", because="", numbers=(Number("n", value, "", limit),))
        for rule, (value, limit) in zip((UNDER_EXPOSED, RESIDUE_LEFT), numbers, strict=True)
    )
    part = replace(first, verdict="clean", judgements=judgements, gaps=())
    return replace(report, parts=(part, *report.parts[1:])), part.component


@pytest.mark.parametrize(
    ("method", "numbers", "wrong"),
    [
        ("ic,9,ug/cm2,5", ((12.0, 10.0), (1.0, 2.5)), {"R2"}),  # 1.2 and 2.5 times within the limit
        ("ic,9,ug/cm2,5", ((40.0, 10.0), (1.0, 2.5)), {"R7"}),
        ("tear-off,9,%,5", ((12.0, 10.0), (1.0, 2.5)), {"R7"}),  # it does not see the surface
        ("ic,9,ug/cm2,5", ((25.0, 10.0), (1.0, 2.5)), {"R2", "R7"}),
    ],
)
def test_an_escape_counts_against_the_rule_that_was_nearest_to_its_limit(tmp_path, method, numbers, wrong):
    path = tmp_path / "m.csv"
    report, name = cleared(*numbers)
    path.write_text(f"{HEAD}{name},{method}\n", "utf-8")
    found = {each.rule.id: each for each in compared(report, path).rules}
    assert {rule for rule, each in found.items() if each.clean_wrong} == wrong
    assert not any(each.clean_right for each in found.values())
    path.write_text(f"{HEAD}{name},{method.replace('9', '1')}\n", "utf-8")
    found = {each.rule.id: each for each in compared(report, path).rules}
    assert {rule for rule, each in found.items() if each.clean_right} == ({"R7"} if "tear" in method else {"R2", "R7"})


def test_a_tear_off_shows_nothing_of_a_fault_on_the_surface(tmp_path):
    path = tmp_path / "m.csv"
    report, name = cleared((1.0, 10.0), (1.0, 2.5))
    part = report.parts[0]
    fault = replace(part.judgements[0], verdict="dirty")
    dirty = replace(report, parts=(replace(part, verdict="dirty", judgements=(fault,)), *report.parts[1:]))
    for method, expected in (("tear-off,1,%,5", set()), ("sir,9,Gohm,1", {"R2"})):
        path.write_text(f"{HEAD}{name},{method}\n", "utf-8")
        assert {each.rule.id for each in compared(dirty, path).rules if each.faults_wrong} == expected


@pytest.mark.slow
def test_renewals_of_a_gap_count_as_room_too(report, file):
    """An escape whose gap is barely renewed often enough counts against R6 and not against R7."""
    clean = [part for part in report.parts if part.verdict == "clean" and part.gaps]
    part = clean[0]
    gap = replace(part.gaps[0], exchanges_needed=part.gaps[0].stages[0].exchanges / 1.001)
    barely = replace(part, gaps=(gap,))
    parts = tuple(barely if each is part else each for each in report.parts)
    path = file.parent / "one.csv"
    path.write_text(f"{HEAD}{part.component},tear-off,9,%,5\n", "utf-8")
    wrong = {each.rule.id for each in compared(replace(report, parts=parts), path).rules if each.clean_wrong}
    assert wrong == {"R6"}


def test_units_and_senses(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text(
        f"{HEAD}U1,sir,0.2,Gohm,0.1\nU1,ic,6.4516,ug/in2,1\nboard,rose,2,ug/cm2,2\nR1,tear-off,0.04,share,0.05\n",
        "utf-8",
    )
    sir, ic, rose, tear = read_measured(path, ["U1", "R1", "board"]).rows
    assert (sir.value, sir.limit, sir.passed, sir.dirt) == (200.0, 100.0, True, -200.0)
    assert ic.value == pytest.approx(1.0)
    assert not ic.passed
    assert rose.passed, "the limit itself passes"
    assert (tear.value, tear.limit) == pytest.approx((4.0, 5.0))


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", 1, "the table is empty"),
        (HEAD, 1, "0 rows are too few"),
        ("component,method,value,unit\nU1,ic,1,ug/cm2\n", 1, "column 'limit' is missing"),
        (HEAD + "U9,ic,1,ug/cm2,2\n", 2, "the board has no 'U9'"),
        (HEAD + "U1,ic,nan,ug/cm2,2\n", 2, "must be a finite number"),
        (HEAD + "U1,ic,,ug/cm2,2\n", 2, "must be a number"),
        (HEAD + "U1,ic,-1,ug/cm2,2\n", 2, "must lie in 0"),
        (HEAD + "U1,tear-off,101,%,2\n", 2, "must lie in 0 to 100"),
        (HEAD + "U1,ic,1,Mohm,2\n", 2, "ic is not measured in 'Mohm'"),
        (HEAD + "U1,sniff,1,Mohm,2\n", 2, "unknown method 'sniff'"),
        ("# c\n" + HEAD + "U1,ic,1,ug/cm2,2\nR1,ic,1,ug/cm2,2\nU1,ic,2,ug/cm2,2\n", 5, "stands on line 3 already"),
        (HEAD + "U1,ic,1,ug/cm2\n", 2, "has 4 cells"),
    ],
)
def test_one_error_with_file_and_line(tmp_path, text, line, words):
    path = tmp_path / "m.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(CleaningError) as refused:
        read_measured(path, ["U1", "R1"])
    assert str(refused.value).startswith(f"{path}:{line}: ")
    assert words in str(refused.value)


def test_no_correlation_from_figures_that_never_change(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text(HEAD + "".join(f"{name},ic,1,ug/cm2,2\n" for name in ("U1", "C1", "R1", "R2")), "utf-8")
    (found,) = compared(small_report(), path).correlations
    assert (found.rho, found.p_value) == (None, None)

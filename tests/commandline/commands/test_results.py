import json
from pathlib import Path

import pytest
from cleaning_report import small_report
from command import contents, washboard

from washboard import cleaned


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program of which every analysis finds the small report."""
    path = tmp_path / "tiny.wash"
    assert washboard("plan", "tiny", "rinse-only", "-o", path).code == 0
    monkeypatch.setattr(cleaned, "analyse_on", lambda *_, **_named: small_report())
    return path


@pytest.mark.slow
def test_results_are_printed_and_kept(program: Path, tmp_path: Path) -> None:
    table, page, data = tmp_path / "m.csv", tmp_path / "m.html", tmp_path / "m.json"
    table.write_text("# synthetic\ncomponent,method,value,unit,limit\nU1,ic,3,ug/cm2,2\nC1,ic,1,ug/cm2,2\n", "utf-8")
    done = washboard("results", program, table, "--html", page, "--json", data)
    assert (done.code, done.err) == (0, "")
    assert "2 of 2 measured components predicted as measured (100 %)" in done.out
    assert "SYNTHETIC" in done.out
    measured = json.loads(data.read_text("utf-8"))["measured"]
    assert (measured["hit_rate"], measured["unclean_beyond"], measured["clean_within"]) == (1.0, ["U1"], ["C1"])
    html = page.read_text("utf-8")
    assert "What was measured" in html
    assert measured["sha256"] in html
    table.write_text(table.read_text("utf-8").replace("C1,ic,1,", "C1,ic,9,"), "utf-8")
    done = washboard("results", program, table)
    assert done.code == 1
    assert "predicted clean, measured not clean  C1" in done.out


def test_a_bad_table_is_refused_before_the_analysis(program: Path, tmp_path: Path) -> None:
    table = tmp_path / "m.csv"
    table.write_text("component,method,value,unit,limit\nU77,ic,3,ug/cm2,2\n", "utf-8")
    before = contents(tmp_path)
    done = washboard("results", program, table, "--json", tmp_path / "m.json")
    assert done.code == 2
    assert done.err.startswith(f"error: {table}:2: component: the board has no 'U77'")
    assert done.err.count("\n") == 1
    assert contents(tmp_path) == before


@pytest.mark.slow
def test_analyse_keeps_what_was_measured(program: Path, tmp_path: Path) -> None:
    table, page, data = tmp_path / "m.csv", tmp_path / "m.html", tmp_path / "m.json"
    table.write_text("component,method,value,unit,limit\nU1,ic,3,ug/cm2,2\nC1,ic,9,ug/cm2,2\n", "utf-8")
    done = washboard("analyse", program, "--results", table, "--html", page, "--json", data)
    assert done.code == 1
    assert "1 of 2 measured components predicted as measured (50 %)" in done.out
    measured = json.loads(data.read_text("utf-8"))["measured"]
    assert measured["clean_beyond"] == ["C1"]
    assert measured["sha256"] in page.read_text("utf-8")
    assert washboard("analyse", program, "--json", data).code == 1
    assert json.loads(data.read_text("utf-8"))["measured"] is None

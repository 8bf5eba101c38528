import json
from pathlib import Path

import pytest
from command import contents, washboard

from programs.load import load_program


@pytest.mark.slow
def test_a_plan_for_a_cell_states_it_with_its_price_and_gives_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("coal")
    words = ("plan", "tiny", "rinse-only", "--cell", "kr6-bench")
    done = washboard(*words, "-o", tmp_path / "a.wash", "--report", tmp_path / "a.json")
    assert done.code == 0, done.err
    assert "kr6-bench (kr6-r900): " in done.out
    assert "longer than the recipe's limits allow" in done.out
    program, data = load_program(tmp_path / "a.wash"), json.loads((tmp_path / "a.json").read_text())
    assert program.origin.cell == "kr6-bench"
    assert data["cell"] == {"name": "kr6-bench", "sha256": program.origin.cell_sha256}
    assert data["robot"]["planned_s"] == pytest.approx(program.totals.duration_s, abs=1e-3)
    assert data["robot"]["robot_s"] <= 1.03 * data["robot"]["planned_s"]
    assert washboard(*words, "-o", tmp_path / "b.wash").code == 0
    assert (tmp_path / "b.wash").read_bytes() == (tmp_path / "a.wash").read_bytes()
    assert washboard("check", tmp_path / "a.wash", "ur5e-bench").code == 0  # another cell takes it too


def test_a_cell_that_does_not_exist_is_one_error_and_nothing_is_written(tmp_path: Path) -> None:
    done = washboard("plan", "tiny", "--cell", "ur5-bensh", "-o", tmp_path / "a.wash")
    assert done.code == 2
    assert done.err.startswith("error: ")
    assert "ur5-bensh" in done.err
    assert contents(tmp_path) == {}


def test_a_program_does_not_replace_the_cell_it_is_planned_for(tmp_path: Path) -> None:
    cell = tmp_path / "cell.wash"
    cell.write_text("cell: mine\n")
    done = washboard("plan", "tiny", "--cell", cell, "-o", cell)
    assert done.code == 2
    assert "read by this command" in done.err
    assert cell.read_text() == "cell: mine\n"

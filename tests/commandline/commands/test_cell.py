"""``washboard cell``, as a person at a terminal uses it."""

from pathlib import Path

import pytest
from small_cells import CELL
from typer.testing import CliRunner, Result

from commandline.arguments import complete_cell
from commandline.commands.cell import app
from robotcell.cell.load import cell_library, read_cell
from robotcell.cell.robot_library import robot_library
from robotcell.cell.schema import cell_keys, cell_schema


def call(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "160"})


def test_list_names_each_cell_and_each_robot_with_what_it_is() -> None:
    result = call("list")
    assert result.exit_code == 0
    for name in cell_library():
        assert f"{read_cell(name).spec.description}\n" in result.stdout
    for name in (*cell_library(), *robot_library()):
        assert f"  {name} " in result.stdout


@pytest.mark.parametrize("name", cell_library())
def test_show_says_what_a_person_compares_with_the_real_cell(name: str) -> None:
    result = call("show", name, "--board", "tiny")
    assert (result.exit_code, result.stderr) == (0, "")
    for word in ("robot base", "tool 1 cone at home", "jet down", "top up", "board's back right corner", "holder"):
        assert word in result.stdout
    for word in ("FUNCTION clean", "SPRAY with ring60", "UNTIL resistivity_mohm_cm", "No findings."):
        assert word in result.stdout


def test_show_tells_mistakes_by_name(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("[400, -50, 150]}", "[400, 50, 150], rpy_deg: [180, 0, 0]}"), "utf-8")
    result = call("show", file)
    assert result.exit_code == 0
    assert "board-upside-down" in result.stdout
    assert "top down" in result.stdout


def test_a_cell_that_cannot_be_used_is_one_line_on_stderr(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("robot: ur5e", "robot: ur5ee"), "utf-8")
    result = call("show", file)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"error: {file}:2: robot: no robot 'ur5ee'")


def test_schema_and_keys_are_printed_as_they_are() -> None:
    assert call("schema").stdout == cell_schema()
    assert call("keys").stdout == cell_keys()


def test_the_shell_completes_names_of_cells() -> None:
    assert complete_cell("ur5e") == ["ur5e-bench"]
    assert complete_cell("") == list(cell_library())

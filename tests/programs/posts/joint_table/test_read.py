"""Joint tables that are damaged are refused with their row."""

from collections.abc import Callable

import pytest
from installations import small_cell
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.export import export
from programs.posts.joint_table import DIALECT

ROW = 20


@pytest.fixture(scope="module")
def table() -> tuple[str, list[str]]:
    program = PROGRAMS["loop"]()
    ((file, text),) = export(program, small_cell(), "joint-table", joints_of(program)).files.items()
    return file, text.splitlines()


DAMAGES: dict[str, Callable[[str], str]] = {
    "a value lost": lambda row: row.partition(",")[2],
    "two values lost": lambda row: row.rpartition(",")[0].rpartition(",")[0],
    "a value too many": lambda row: f"{row},0",
    "no row": lambda row: "",
    "a quotation mark": lambda row: f'"{row}',
    "no number": lambda row: row.replace(",", ",x", 1),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_row_is_refused(table: tuple[str, list[str]], damage: str) -> None:
    file, lines = table
    text = "\n".join([*lines[:ROW], DAMAGES[damage](lines[ROW]), *lines[ROW + 1 :]])
    with pytest.raises(ProgramError, match="row") as caught:
        DIALECT.read({file: text})
    assert caught.value.line in (ROW + 1, len(lines))

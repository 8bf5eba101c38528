"""Which of file and folder a language takes, and what stands there afterwards."""

from pathlib import Path

import pytest
from command import contents

from programs.posts.dialects import DIALECTS
from reports.files.atomic_write import OutputError
from reports.files.robot_programs import check_output, write_program

ABB, KUKA, UR, VAL3 = (DIALECTS[name] for name in ("abb", "kuka", "ur", "val3"))
ONE = {"tiny.mod": "MODULE tiny\n"}
LONG = {"tiny.pgf": "list\n", "tiny.mod": "main\n", "tiny_01.mod": "part\n"}
PAIR = {"tiny.src": "source\n", "tiny.dat": "data\n"}
PROJECT = {"tiny.pjx": "list\n", "tiny.dtx": "data\n", "start.pgx": "code\n"}


@pytest.mark.parametrize("name", DIALECTS)
def test_a_language_takes_a_folder_and_refuses_a_file_of_another_kind(name: str, tmp_path: Path) -> None:
    check_output(tmp_path / "robot", DIALECTS[name], ())
    check_output(tmp_path, DIALECTS[name], ())
    with pytest.raises(OutputError, match=r"tiny\.pdf: cannot be written: a program in .* Name a "):
        check_output(tmp_path / "tiny.pdf", DIALECTS[name], ())
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("name", [name for name, each in DIALECTS.items() if not each.form.several])
def test_a_language_of_one_file_takes_its_suffix_in_either_case(name: str, tmp_path: Path) -> None:
    suffix = DIALECTS[name].form.suffix
    for each in (suffix.lower(), suffix.upper()):
        check_output(tmp_path / f"tiny{each}", DIALECTS[name], ())


def test_polyscope_has_two_suffixes(tmp_path: Path) -> None:
    check_output(tmp_path / "tiny.urscript", UR, ())
    assert write_program(tmp_path / "tiny.urscript", {"tiny.script": "def tiny():\n"}, UR) == [
        tmp_path / "tiny.urscript"
    ]


@pytest.mark.parametrize("name", [name for name, each in DIALECTS.items() if each.form.several])
def test_a_language_of_several_files_refuses_one_before_the_work(name: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"is several files .* Name a folder"):
        check_output(tmp_path / f"tiny{DIALECTS[name].form.suffix}", DIALECTS[name], ())


def test_a_file_that_is_read_and_a_folder_that_is_a_file_are_refused(tmp_path: Path) -> None:
    board, plain = tmp_path / "board.mod", tmp_path / "robot"
    plain.write_text("mine")
    with pytest.raises(OutputError, match="it is read by this command"):
        check_output(board, ABB, (board,))
    with pytest.raises(OutputError, match="not a folder"):
        check_output(plain, ABB, ())
    with pytest.raises(OutputError, match="no folder"):
        check_output(tmp_path / "no" / "tiny.mod", ABB, ())


def test_a_longer_program_does_not_go_into_one_file(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"longer than one file of ABB RAPID holds, and has 3. Name a folder"):
        write_program(tmp_path / "tiny.mod", LONG, ABB)
    assert contents(tmp_path) == {}
    assert write_program(tmp_path / "tiny", LONG, ABB) == [tmp_path / "tiny" / name for name in LONG]


def test_one_file_has_the_given_name_or_its_own_in_a_folder(tmp_path: Path) -> None:
    assert write_program(tmp_path / "job7.mod", ONE, ABB) == [tmp_path / "job7.mod"]
    assert write_program(tmp_path / "robot", ONE, ABB) == [tmp_path / "robot" / "tiny.mod"]
    assert write_program(tmp_path / "robot", ONE, ABB) == [tmp_path / "robot" / "tiny.mod"]
    assert set(contents(tmp_path)) == {"job7.mod", "robot/tiny.mod"}


def test_a_list_of_a_longer_program_is_not_left_beside_a_short_one(tmp_path: Path) -> None:
    write_program(tmp_path / "robot", LONG, ABB)
    before = contents(tmp_path)
    with pytest.raises(OutputError, match=r"tiny\.pgf there belongs to a longer program"):
        write_program(tmp_path / "robot", ONE, ABB)
    assert contents(tmp_path) == before


def test_several_files_leave_what_is_not_theirs_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="holds something else"):
        write_program(tmp_path, PAIR, KUKA)
    write_program(tmp_path / "robot", PAIR, KUKA)
    assert set(contents(tmp_path)) == {"notes.txt", "robot/tiny.src", "robot/tiny.dat"}


def test_a_project_is_a_folder_of_its_name(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert write_program(tmp_path, PROJECT, VAL3)[0] == tmp_path / "tiny" / "tiny.pjx"
    write_program(tmp_path / "new", PROJECT, VAL3)
    assert {name for name in contents(tmp_path) if name.startswith("new/")} == {f"new/tiny/{name}" for name in PROJECT}

"""Which of file and folder a language takes, and what stands there afterwards."""

import os
from dataclasses import replace
from pathlib import Path

import pytest
from command import contents
from installations import small_cell
from robot_programs import three_speeds

from programs.posts.dialect import Dialect
from programs.posts.dialects import DIALECTS
from reports.files.robot_programs import check_output, write_program
from reports.files.write_run import check_places
from specs.output_file import OutputError, OutputFile, output_place

ABB, KUKA, UR, VAL3 = (DIALECTS[name] for name in ("abb", "kuka", "ur", "val3"))
ONE = {"tiny.mod": "MODULE tiny\n"}
LONG = {"tiny.pgf": "list\n", "tiny.mod": "main\n", "tiny_01.mod": "part\n"}
PAIR = {"tiny.src": "source\n", "tiny.dat": "data\n"}
PROJECT = {"tiny.pjx": "list\n", "tiny.dtx": "data\n", "start.pgx": "code\n"}

PAGE = "# Commissioning\n"

PROGRAM = three_speeds()


def check(output: Path, language: Dialect) -> None:
    check_output(output_place(output), language, PROGRAM, small_cell())


def write(output: Path, files: dict[str, str], language: Dialect) -> list[Path]:
    return write_program(output_place(output), files, language, PAGE)


@pytest.mark.parametrize("name", DIALECTS)
def test_a_language_takes_a_folder_and_refuses_a_file_of_another_kind(name: str, tmp_path: Path) -> None:
    check(tmp_path / "robot", DIALECTS[name])
    check(tmp_path, DIALECTS[name])
    with pytest.raises(OutputError, match=r"tiny\.pdf: cannot be written: a program in .* Name a "):
        check(tmp_path / "tiny.pdf", DIALECTS[name])
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("name", [name for name, each in DIALECTS.items() if not each.form.several])
def test_a_language_of_one_file_takes_its_suffix_in_either_case(name: str, tmp_path: Path) -> None:
    suffix = DIALECTS[name].form.suffix
    for each in (suffix.lower(), suffix.upper()):
        check(tmp_path / f"tiny{each}", DIALECTS[name])


def test_polyscope_has_two_suffixes(tmp_path: Path) -> None:
    check(tmp_path / "tiny.urscript", UR)
    assert write(tmp_path / "tiny.urscript", {"tiny.script": "def tiny():\n"}, UR) == [
        *(tmp_path / "tiny.urscript", tmp_path / "tiny.urscript.commissioning.md")
    ]


@pytest.mark.parametrize("name", [name for name, each in DIALECTS.items() if each.form.several])
def test_a_language_of_several_files_refuses_one_before_the_work(name: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"is several files .* Name a folder"):
        check(tmp_path / f"tiny{DIALECTS[name].form.suffix}", DIALECTS[name])


def test_a_file_that_is_read_and_a_folder_that_is_a_file_are_refused(tmp_path: Path) -> None:
    board, plain = tmp_path / "board.mod", tmp_path / "robot"
    plain.write_text("mine")
    board.touch()
    (tmp_path / "link.mod").hardlink_to(board)
    (tmp_path / "other.mod").symlink_to(board)
    for name in ("board.mod", "link.mod", "other.mod"):
        with pytest.raises(OutputError, match="it is read by this command"):
            check_places((board,), (OutputFile(tmp_path / name),))
    with pytest.raises(OutputError, match="not a folder"):
        check(plain, ABB)
    with pytest.raises(OutputError, match="it is read by this command"):
        check_places((board, plain), (OutputFile(tmp_path / "link.mod", in_place=True),), edited=plain)
    with pytest.raises(OutputError, match="it is read by this command"):
        check_places((board, plain), (OutputFile(plain),), edited=plain)
    check_places((board, plain), (OutputFile(plain, in_place=True),), edited=plain)
    with pytest.raises(OutputError, match="no folder"):
        check(tmp_path / "no" / "tiny.mod", ABB)


def test_a_longer_program_does_not_go_into_one_file(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"longer than one file of ABB RAPID holds: .* steps. Name a folder"):
        write(tmp_path / "tiny.mod", LONG, ABB)
    assert contents(tmp_path) == {}
    names = (*LONG, "tiny.pgf.commissioning.md")
    assert write(tmp_path / "tiny", LONG, ABB) == [tmp_path / "tiny" / name for name in names]


def test_a_longer_program_is_refused_before_the_work(tmp_path: Path) -> None:
    short = replace(ABB, most_steps=3)
    with pytest.raises(OutputError, match=r"longer than one file of ABB RAPID holds: 3 steps. Name a folder"):
        check(tmp_path / "tiny.mod", short)
    check(tmp_path / "tiny", short)


def test_a_folder_is_made_with_those_above_it(tmp_path: Path) -> None:
    deep = tmp_path / "deep" / "new" / "folder"
    check(deep, ABB)
    assert contents(tmp_path) == {}
    assert write(deep, LONG, ABB)[0] == deep / "tiny.pgf"
    assert write(tmp_path / "other" / "way", ONE, ABB)[0] == tmp_path / "other" / "way" / "tiny.mod"
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file is not a folder"):
        check(tmp_path / "file" / "in" / "it", ABB)


def test_one_file_has_the_given_name_or_its_own_in_a_folder(tmp_path: Path) -> None:
    assert write(tmp_path / "job7.mod", ONE, ABB)[0] == tmp_path / "job7.mod"
    assert write(tmp_path / "robot", ONE, ABB)[0] == tmp_path / "robot" / "tiny.mod"
    assert write(tmp_path / "robot", ONE, ABB)[0] == tmp_path / "robot" / "tiny.mod"
    assert {name for name in contents(tmp_path) if not name.endswith(".md")} == {"job7.mod", "robot/tiny.mod"}


def test_each_program_has_its_page_beside_it_and_no_two_have_one(tmp_path: Path) -> None:
    """Programs of one file in one folder: of two boards, and of one in two languages."""
    for files, language in (ONE, ABB), ({"other.mod": ""}, ABB), ({"tiny.script": ""}, UR):
        write(tmp_path, files, language)
        write(tmp_path / f"given{language.form.suffix}", files, language)
    programs = {"tiny.mod", "other.mod", "tiny.script", "given.mod", "given.script"}
    assert set(contents(tmp_path)) == programs | {f"{name}.commissioning.md" for name in programs}
    assert contents(tmp_path)["given.mod.commissioning.md"] == PAGE.encode()


def test_a_program_is_not_written_without_its_page(tmp_path: Path) -> None:
    (tmp_path / "tiny.mod.commissioning.md").mkdir()
    for place in (tmp_path / "tiny.mod", tmp_path):
        with pytest.raises(OutputError, match=r"commissioning\.md: cannot be written"):
            write(place, ONE, ABB)
    with pytest.raises(OutputError, match=r"commissioning\.md: cannot be written: it is a folder"):
        check(tmp_path / "tiny.mod", ABB)
    assert contents(tmp_path) == {}


def test_a_pipe_takes_the_program_alone(tmp_path: Path) -> None:
    pipe = tmp_path / "tiny.mod"
    os.mkfifo(pipe)
    reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    assert write(pipe, ONE, ABB) == [pipe]
    assert os.read(reading, 100) == ONE["tiny.mod"].encode()
    os.close(reading)
    assert [each.name for each in tmp_path.iterdir()] == ["tiny.mod"]


def test_a_list_of_a_longer_program_is_not_left_beside_a_short_one(tmp_path: Path) -> None:
    write(tmp_path / "robot", LONG, ABB)
    before = contents(tmp_path)
    with pytest.raises(OutputError, match=r"tiny\.pgf there belongs to a longer program"):
        write(tmp_path / "robot", ONE, ABB)
    assert contents(tmp_path) == before


def test_several_files_leave_what_is_not_theirs_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="holds something else"):
        write(tmp_path, PAIR, KUKA)
    write(tmp_path / "robot", PAIR, KUKA)
    page = "robot/tiny.src.commissioning.md"
    assert set(contents(tmp_path)) == {"notes.txt", "robot/tiny.src", "robot/tiny.dat", page}


def test_a_project_is_a_folder_of_its_name(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert write(tmp_path, PROJECT, VAL3)[0] == tmp_path / "tiny" / "tiny.pjx"
    write(tmp_path / "new", PROJECT, VAL3)
    assert {name for name in contents(tmp_path) if name.startswith("new/")} == {
        *(f"new/tiny/{name}" for name in (*PROJECT, "tiny.pjx.commissioning.md"))
    }

"""Programs in robots' languages, read as timed programs."""

import re
from pathlib import Path

import numpy as np
import pytest
from installations import ARM_LANGUAGES, for_language, small_cell
from robot_programs import PROGRAMS, joints_of

from programs import foreign
from programs.errors import ProgramError
from programs.export import export
from programs.foreign import is_foreign, named_cell, read_files, rebuild_program
from programs.posts.dialects import DIALECTS
from programs.program import MoveTo, SetNozzle, TimedProgram, Wait

POSES = [name for name in ARM_LANGUAGES if name != "linuxcnc"]


def written(folder: Path, dialect: str, made: str = "three_speeds") -> TimedProgram:
    program = PROGRAMS[made]()
    joints = joints_of(program) if DIALECTS[dialect].needs_joints else None
    for name, text in export(program, for_language(small_cell(), dialect), dialect, joints).files.items():
        (folder / name).write_text(text, "ascii")
    return program


def places(program: TimedProgram) -> np.ndarray:
    return np.array([item.position for item in program.instructions if isinstance(item, MoveTo)])


def jets_of(program: TimedProgram) -> int:
    return sum(isinstance(item, SetNozzle) and item.spraying for item in program.instructions)


@pytest.mark.parametrize("dialect", POSES)
def test_an_exported_program_is_shown_as_it_was_planned(dialect: str, tmp_path: Path) -> None:
    planned = written(tmp_path, dialect)
    name, files = read_files(tmp_path)
    assert name == dialect
    assert named_cell(files) in ("bench", "")
    shown = rebuild_program(name, files, small_cell())
    assert shown.origin.board == planned.origin.board or dialect in ("fanuc", "yaskawa")
    np.testing.assert_allclose(places(shown).min(axis=0), places(planned).min(axis=0), atol=0.01)
    np.testing.assert_allclose(places(shown).max(axis=0), places(planned).max(axis=0), atol=0.01)
    jets = [
        sum(isinstance(item, SetNozzle) and item.spraying for item in each.instructions) for each in (planned, shown)
    ]
    assert jets[0] == jets[1]
    assert sum(isinstance(item, Wait) for item in shown.instructions) > 0
    assert 0.5 < shown.totals.duration_s / planned.totals.duration_s < 1.2


def test_a_line_that_is_not_understood_is_named(tmp_path: Path) -> None:
    written(tmp_path, "abb")
    (place,) = tmp_path.iterdir()
    text = place.read_text()
    line = next(at for at, each in enumerate(text.splitlines(), start=1) if "MoveL p1" in each)
    place.write_text(text.replace("MoveL p1", "MoveC p1"))
    with pytest.raises(ProgramError, match=rf"{place.name}:{line}: unknown statement 'MoveC p1"):
        rebuild_program(*read_files(place), small_cell())


def test_what_is_no_robot_program_is_refused(tmp_path: Path) -> None:
    assert not is_foreign(tmp_path / "a.wash")
    assert is_foreign(tmp_path / "a.SRC")
    with pytest.raises(ProgramError, match="no program in a robot's language"):
        read_files(tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (r"p1:=\[\[0\.000,", "p1:=[[2000000.000,", "this statement leads more than 1,000 m away"),
        (r"WaitTime .*;", "WaitTime 20000000;", "this statement ends after 20,000,"),
    ],
)
def test_a_program_that_leaves_every_robots_space_or_never_ends_is_refused(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    written(tmp_path, "abb")
    (place,) = tmp_path.iterdir()
    text, count = re.subn(old, new, place.read_text(), count=1)
    assert count == 1
    place.write_text(text)
    with pytest.raises(ProgramError, match=rf"{place.name}:\d+: {message}"):
        rebuild_program(*read_files(place), small_cell())


def test_files_are_bounded_one_by_one_and_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, "fanuc")
    sizes = [each.stat().st_size for each in tmp_path.iterdir()]
    assert len(sizes) > 1
    monkeypatch.setattr(foreign, "_LARGEST_TEXT", max(sizes))
    with pytest.raises(ProgramError, match="bytes in its files; no robot's program has so many"):
        read_files(tmp_path)
    largest = max(tmp_path.iterdir(), key=lambda each: each.stat().st_size)
    monkeypatch.setattr(foreign, "_LARGEST_TEXT", max(sizes) - 1)
    with pytest.raises(ProgramError, match=largest.name):
        read_files(largest)


def test_a_text_that_is_no_ascii_is_refused_with_its_line(tmp_path: Path) -> None:
    place = tmp_path / "a.mod"
    place.write_bytes("MODULE a\n! schön\n".encode())
    with pytest.raises(ProgramError, match=r"a.mod:2: this is not the ASCII text of a robot program"):
        read_files(place)


def test_a_folder_of_many_files_begins_with_the_one_that_no_other_mentions(tmp_path: Path) -> None:
    for number in range(1, 700):
        (tmp_path / f"p-{number}.src").write_text(f"DEF p{number}()\n p-{number + 1}()\nEND\n")
    assert next(iter(read_files(tmp_path)[1])) == "p-1.src"


def test_a_project_may_be_one_folder_deep(tmp_path: Path) -> None:
    deep = tmp_path / "p" / "p" / "p"
    deep.mkdir(parents=True)
    (deep / "a.src").write_text("DEF a()\nEND\n")
    assert list(read_files(deep.parent)[1]) == ["a.src"]
    with pytest.raises(ProgramError, match="no program in a robot's language in this folder"):
        read_files(tmp_path)

import re
from pathlib import Path

import pytest
from command import contents, washboard
from hostile_cells import hostile_text
from robot_programs import PROGRAMS

from programs import native
from programs.posts.dialects import DIALECTS
from programs.posts.rebuilt import ReadLine, ReadRepeat
from programs.posts.robots.abb.read import DIALECT


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small program above the sample board ``tiny``."""
    file = tmp_path_factory.mktemp("made") / "loop.wash"
    file.write_text(native.render(PROGRAMS["loop"]()))
    return file


def test_the_languages_are_listed() -> None:
    outcome = washboard("export", "--list")
    assert outcome.code == 0
    assert [line.split()[0] for line in outcome.out.splitlines()] == list(DIALECTS)
    assert "class 1. One .mod file; several and a .pgf from 2000 steps on." in outcome.out
    assert "Several files (.src .dat)." in outcome.out


@pytest.mark.slow
def test_a_program_is_written_as_the_robot_does_it(made: Path, tmp_path: Path) -> None:
    out = tmp_path / "loop.mod"
    outcome = washboard("export", made, "--cell", "irb1200-bench", "-o", out, "--board", "tiny")
    assert outcome.code == 0, outcome.err
    assert f"Written  {out}" in outcome.out
    assert "wrong by at most" in outcome.out
    assert sorted(contents(tmp_path)) == ["loop.mod", "loop.mod.commissioning.md"]
    steps = DIALECT.read({"loop.mod": out.read_text("ascii")}).steps
    assert sum(isinstance(step, ReadLine) for step in steps) >= 6
    assert any(isinstance(step, ReadRepeat) for step in steps)
    assert "MoveAbsJ [[" in out.read_text("ascii")


def test_another_makers_language_is_refused_before_anything_is_checked(made: Path, tmp_path: Path) -> None:
    out = tmp_path / "loop.mod"
    outcome = washboard("export", made, "--cell", "kr6-bench", "--dialect", "abb", "-o", out)
    assert outcome.code == 2
    (line,) = outcome.err.splitlines()
    assert "ABB RAPID is for ABB, and robot kr6-r900 of cell kr6-bench is by KUKA" in line
    assert "choose kuka, or a cell with a robot of ABB, or export --without-joints." in line
    assert not out.exists()


@pytest.mark.slow
def test_poses_alone_are_written_for_another_makers_arm(made: Path, tmp_path: Path) -> None:
    out = tmp_path / "loop.mod"
    words = ("--cell", "kr6-bench", "--dialect", "abb", "--without-joints", "-o", out, "--board", "tiny")
    outcome = washboard("export", made, *words)
    assert outcome.code == 0, outcome.err
    assert "without-joints" in outcome.out
    text = out.read_text("ascii")
    assert "! warning: Written without joint values." in text
    assert "MoveAbsJ" not in text
    assert "jointtarget" not in text


def test_a_robot_of_no_maker_needs_a_language(made: Path, tmp_path: Path) -> None:
    outcome = washboard("export", made, "--cell", "gantry")
    assert outcome.code == 2
    assert "give --dialect" in outcome.err
    assert "linuxcnc, heidenhain, sinumerik, fanuc-cnc, joint-table" in outcome.err


def test_without_a_place_nothing_is_written_and_everything_said(made: Path, tmp_path: Path) -> None:
    before = contents(made.parent)
    outcome = washboard("export", made, "--cell", "ur5e-bench", "--dialect", "joint-table")
    assert outcome.code == 0, outcome.err
    assert "Nothing was written" in outcome.out
    assert contents(made.parent) == before


@pytest.mark.slow
def test_without_the_board_its_place_is_not_known(made: Path, tmp_path: Path) -> None:
    words = ("export", made, "--cell", "ur5e-bench", "-o", tmp_path / "a.script")
    refused = washboard(*words)
    assert refused.code == 2
    assert "First board-place-unknown at board: cell ur5e-bench holds the board by its front left corner" in refused.err
    assert contents(tmp_path) == {}
    assert washboard(*words, "--allow", "board-place-unknown").code == 0


@pytest.mark.slow
def test_an_error_forbids_it_unless_it_is_allowed_by_name(made: Path, tmp_path: Path) -> None:
    cell = tmp_path / "cell.yaml"
    text = washboard_cell().read_text("utf-8")
    cell.write_text(text)
    program = tmp_path / "odd.wash"
    program.write_text(made.read_text().replace("NOZZLE ring60", "NOZZLE lance"))
    out = tmp_path / "out.script"
    words = ("export", program, "--cell", cell, "-o", out, "--board", "tiny")
    refused = washboard(*words)
    assert refused.code == 2
    assert "--allow no-valve" in refused.err
    assert not out.exists()
    assert washboard(*words, "--allow", "no-valve").code == 0
    assert "# spray on" in out.read_text("ascii")


def washboard_cell() -> Path:
    from robotcell.cell.load import cell_library

    return cell_library()["ur5e-bench"]


@pytest.mark.slow
def test_a_language_of_axes_is_refused_with_what_the_check_found(made: Path, tmp_path: Path) -> None:
    """A gantry whose program lies beyond the end of an axis."""
    far = tmp_path / "far.wash"
    far.write_text(
        re.sub(r"(?m)^(\S+ MOVE) (\S+)", lambda at: f"{at[1]} {float(at[2]) + 3000.0:.3f}", made.read_text())
    )
    for dialect in ("linuxcnc", "heidenhain", "joint-table"):
        refused = washboard("export", far, "--cell", "gantry", "--dialect", dialect, "-o", tmp_path / dialect)
        assert refused.code == 2
        assert "is written from the motion of the joints, and the robot has none for this program: " in refused.err
        assert re.search(r"\bX\b", refused.err)
        assert not (tmp_path / dialect).exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--cell", "ur5e-bench", "--dialect", "cobol"], "there is no dialect 'cobol'"),
        (["--cell", "ur99"], "ur99"),
        ([], "--cell"),
    ],
)
def test_what_is_missing_or_unknown_is_one_line(made: Path, words: list[str], said: str) -> None:
    outcome = washboard("export", made, *words)
    assert outcome.code == 2
    assert said in outcome.err
    assert len(outcome.err.splitlines()) == 1


def test_a_file_that_is_no_program_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "x.wash"
    file.write_text("hello")
    outcome = washboard("export", file, "--cell", "ur5e-bench")
    assert outcome.code == 2
    assert "x.wash" in outcome.err


def test_the_program_itself_is_not_overwritten(made: Path) -> None:
    before = contents(made.parent)
    outcome = washboard("export", made, "--cell", "ur5e-bench", "-o", made)
    assert outcome.code == 2
    assert "it is read by this command" in outcome.err
    assert contents(made.parent) == before


@pytest.mark.parametrize(
    ("cell", "place", "reason"),
    [
        ("irb1200-bench", "loop.src", "a program in ABB RAPID is a .mod file. Name a .mod file, or a folder"),
        ("kr6-bench", "loop.src", "a program in KUKA KRL is several files (.src, .dat). Name a folder"),
    ],
)
def test_a_place_of_another_kind_is_refused(made: Path, tmp_path: Path, cell: str, place: str, reason: str) -> None:
    outcome = washboard("export", made, "--cell", cell, "-o", tmp_path / place, "--board", "tiny")
    assert outcome.code == 2
    assert reason in outcome.err
    assert len(outcome.err.splitlines()) == 1
    assert contents(tmp_path) == {}


def test_a_folder_is_made_for_what_the_maker_expects(made: Path, tmp_path: Path) -> None:
    outcome = washboard("export", made, "--cell", "irb1200-bench", "-o", tmp_path / "robot", "--board", "tiny")
    assert outcome.code == 0, outcome.err
    assert f"Written  {tmp_path / 'robot' / 'tiny__smt_aqueous.mod'}" in outcome.out
    program = "robot/tiny__smt_aqueous.mod"
    assert list(contents(tmp_path)) == [program, f"{program}.commissioning.md"]


def test_a_place_that_cannot_be_written_is_said(made: Path, tmp_path: Path) -> None:
    outcome = washboard("export", made, "--cell", "ur5e-bench", "-o", tmp_path / "no" / "where.script")
    assert outcome.code == 2
    assert "where.script" in outcome.err


@pytest.mark.slow
def test_a_board_that_is_at_hand_is_not_called_unknown_where_the_robot_cannot_do_it(tmp_path: Path) -> None:
    (tmp_path / "far.yaml").write_text(hostile_text("ur5e-bench", "far"))
    washboard("plan", "tiny", "smt-aqueous", "-o", tmp_path / "tiny.wash")
    words = ("export", tmp_path / "tiny.wash", "--cell", tmp_path / "far.yaml", "--dialect", "ur", "--board", "tiny")
    refused = washboard(*words, "-o", tmp_path / "out.script")
    assert refused.code == 2
    assert "board-place-unknown" not in refused.err + refused.out

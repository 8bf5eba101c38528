"""What every robot language has to keep to: a dialect is enrolled by standing in ``DIALECTS``."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from installations import ARM_LANGUAGES, bare_cell, for_language, small_cell
from robot_programs import PROGRAMS, joints_of, three_speeds
from small_programs import DOWN, program_of, programs

from programs import native
from programs.errors import ProgramError
from programs.export import Exported, export
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Wait

NAMED = pytest.mark.parametrize("name", list(ARM_LANGUAGES))


@cache
def motion_of(made: str, with_joints: bool) -> MotionProgram:
    program = PROGRAMS[made]()
    return make_motion(program, small_cell(), joints_of(program) if with_joints else None)


def exported(name: str, program: TimedProgram, cell: Installation | None = None) -> Exported:
    joints = joints_of(program) if DIALECTS[name].needs_joints else None
    return export(program, for_language(cell or small_cell(), name), name, joints)


STEMS = {
    "fanuc": "[A-Z][A-Z0-9_]{0,7}", "yaskawa": "[A-Z][A-Z0-9_]{0,31}", "melfa": "[A-Z][A-Z0-9]{0,11}",
    "linuxcnc": "[a-z][a-z0-9_]{0,39}", "kuka": r"[A-Za-z]\w{0,23}", "val3": r"[A-Za-z]\w{0,14}",
}  # fmt: skip
"""Names of files that controllers take, as far as not all of ABB's 32 letters, digits and underscores."""
ODD_BOARDS = (
    "smt-demo",
    "2 Platine größer v1.2",
    "CON",
    "main",
    "tiny_01",
    "...",
    "x" * 90,
    "END",
    "наклейка",
    "my_sh",
    "my_bg",
    "watch",
)


@NAMED
@pytest.mark.parametrize("board", ODD_BOARDS)
def test_the_controller_takes_the_names_of_the_files_whatever_the_boards(name: str, board: str) -> None:
    """On a disk that does not tell capital letters apart, too."""
    made = PROGRAMS["two_tools"]()
    done = exported(name, replace(made, origin=replace(made.origin, board=board)))
    stem, form = re.compile(STEMS.get(name, r"[A-Za-z]\w{0,59}"), re.ASCII), DIALECTS[name].form
    assert next(iter(done.files)).endswith(form.suffix)
    assert len({file.lower() for file in done.files}) == len(done.files)
    assert (len(done.files) > 1) == bool(form.several)
    for file in done.files:
        assert stem.fullmatch(file.rpartition(".")[0])
        assert file.lower() not in {f"con.{file.rpartition('.')[2].lower()}"}
        assert Path(file).suffix in (form.several or (form.suffix,))


@NAMED
def test_a_known_joint_motion_changes_nothing_that_is_sprayed(name: str) -> None:
    dialect, cell = DIALECTS[name], small_cell()
    motion = motion_of("two_tools", True)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()


@pytest.mark.parametrize("text", ["", "?", "\n" * 9, "<a></a>", "1,2,3\n", "node,time_s\n1,0\n"])
@pytest.mark.parametrize("name", list(DIALECTS))
def test_what_is_no_program_of_a_language_is_refused_by_the_name_of_its_file(name: str, text: str) -> None:
    with pytest.raises(ProgramError, match=r"(first|other)\.txt"):
        DIALECTS[name].read({"first.txt": text, "other.txt": ""})


@NAMED
def test_the_same_program_gives_the_same_bytes(name: str) -> None:
    once, again = (exported(name, three_speeds()).files for _ in range(2))
    assert list(once.items()) == list(again.items())


@NAMED
def test_the_header_says_the_worst_event_error(name: str) -> None:
    done = exported(name, PROGRAMS["in_flight"]())
    said = f"Worst event error {done.error.distance_mm:.2f} mm, {1e3 * done.error.time_s:.1f} ms"
    assert any(said in text for text in done.files.values())


@NAMED
def test_what_the_cell_does_not_map_is_a_comment_and_a_finding(name: str) -> None:
    done = exported(name, three_speeds(), bare_cell())
    assert {finding.rule.id for finding in done.findings} >= {"no-channel"}
    assert any("pressure_bar = 3.500" in text for text in done.files.values())


@NAMED
def test_a_small_program_reads_as_an_integrator_would_want_it(name: str, golden: Callable[[str, str], None]) -> None:
    program = replace(PROGRAMS["loop"](), findings=())
    for file, text in exported(name, program).files.items():
        golden(f"posts/{name}/{file}", text)


ROUND = (0.0, 0.0, 0.0, 1.0)
"""Half a turn from DOWN."""
START, LOW = MoveTo(0.0, (0.0, 0.0, 110.0), DOWN, 0.0, ""), MoveTo(0.0, (0.0, 0.0, 0.0), DOWN, 0.0, "")


def turned_at(x: float) -> TimedProgram:
    """From 12.345, as far as x and a quarter of a turn in two seconds, then half a turn in one."""
    quarter = (0.0, 0.5**0.5, 0.0, 0.5**0.5)
    told: list[Instruction] = [MoveTo(0.0, (12.345, 0.0, 60.0), DOWN, 0.0, "")]
    told += [MoveTo(2.0, (x, 0.0, 60.0), quarter, 0.0, ""), Command(2.0, "GRIP", ("open",), "")]
    told += [MoveTo(3.0, (12.345, 0.0, 60.0), (0.0, 0.5**0.5, 0.0, -(0.5**0.5)), 0.0, "")]
    return program_of(*told, SetNozzle(3.0, False, ""))


@pytest.mark.parametrize("name", [name for name, dialect in ARM_LANGUAGES.items() if not dialect.needs_joints])
def test_a_turn_whose_way_is_lost_in_the_last_digit_is_told_as_one_on_the_spot(name: str) -> None:
    on_the_spot, nearly = ("\n".join(exported(name, turned_at(x)).files.values()) for x in (12.345, 12.346))
    assert nearly.replace("12.346", "12.345").replace("0.012346", "0.012345") == on_the_spot
    assert nearly != on_the_spot


@pytest.mark.slow
@NAMED
@settings(max_examples=15)
@example(program=program_of(START, LOW, MoveTo(0.0, (0.0, 0.0, 0.001), ROUND, 0.0, ""), SetNozzle(0.0, False, "")))
@example(  # a line of 0.004 mm that is divided for its output
    program=program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), ""),
        LOW,
        SetNozzle(0.1, True, "a"),
        Wait(0.21, 0.0, "b"),
        MoveTo(0.21, (0.002, 0.003, 0.002), DOWN, 0.0, "a"),
        SetNozzle(0.21, False, ""),
    )
)
@example(  # a command at a place that is written like the one before it
    program=program_of(
        LOW,
        Command(0.0005, "FUNCTION", ("clean",), ""),
        MoveTo(8.0, (0.004, 1.0, 0.0), DOWN, 0.0, ""),
        SetNozzle(8.0, False, ""),
    )
)
@example(  # the first tool is named where the orifice jumps: as if it had been another
    program=program_of(
        START,
        Command(0.0, "NOZZLE", ("a", "TOOL", "1"), ""),
        LOW,
        MoveTo(1.0, LOW.position, ROUND, 0.0, ""),
        SetNozzle(1.0, False, ""),
    )
)
@example(  # a tool that another one takes the place of before anything moves
    program=program_of(
        START,
        Command(0.0, "NOZZLE", ("a", "TOOL", "0"), ""),
        Command(0.0, "NOZZLE", ("a", "TOOL", "1"), ""),
        LOW,
        SetNozzle(1.0, False, ""),
    )
)
@example(  # so it may be where the cell does not know what a routine moves
    program=program_of(
        START,
        Command(0.0, "CALL", ("other",), ""),
        LOW,
        MoveTo(1.0, (0.0, 0.0, 5.0), ROUND, 0.0, ""),
        SetNozzle(1.0, False, ""),
    )
)
@given(program=programs().map(lambda program: native.parse(native.render(program))))  # as a file holds it
def test_any_sound_program_is_read_back_as_planned(name: str, program: TimedProgram) -> None:
    dialect, cell = DIALECTS[name], small_cell()
    motion = make_motion(program, cell, joints_of(program) if dialect.needs_joints else None)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()

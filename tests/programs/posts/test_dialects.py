"""What every robot language has to keep to: a dialect is enrolled by standing in ``DIALECTS``."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest
from hypothesis import given, settings
from installations import bare_cell, small_cell
from robot_programs import PROGRAMS, joints_of, three_speeds
from small_programs import programs

from programs.events import lower
from programs.export import Exported, export
from programs.installation import Installation
from programs.motion import MotionProgram
from programs.posts import native
from programs.posts.compare import compare
from programs.posts.dialects import DIALECTS
from programs.program import TimedProgram
from programs.steps import make_motion

CASES = [pytest.param(name, made, id=f"{name}-{made}") for name in DIALECTS for made in PROGRAMS]
NAMED = pytest.mark.parametrize("name", list(DIALECTS))


@cache
def motion_of(made: str, with_joints: bool) -> MotionProgram:
    program = PROGRAMS[made]()
    return make_motion(program, small_cell(), joints_of(program) if with_joints else None)


def exported(name: str, program: TimedProgram, cell: Installation | None = None) -> Exported:
    joints = joints_of(program) if DIALECTS[name].needs_joints else None
    return export(program, cell or small_cell(), name, joints)


@pytest.mark.parametrize(("name", "made"), CASES)
def test_what_is_written_is_read_back_as_planned(name: str, made: str) -> None:
    dialect, cell = DIALECTS[name], small_cell()
    motion = motion_of(made, dialect.needs_joints)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()


@pytest.mark.parametrize(("name", "made"), CASES)
def test_every_file_is_ascii_and_no_line_is_too_long(name: str, made: str) -> None:
    dialect = DIALECTS[name]
    files = dialect.render(lower(motion_of(made, dialect.needs_joints), dialect.capability), small_cell())
    assert files
    for file, text in files.items():
        assert file.isascii()
        assert "/" not in file
        assert text.isascii()
        assert max(len(line) for line in text.splitlines()) <= dialect.longest_line
        assert text.endswith("\n")


@NAMED
def test_a_known_joint_motion_changes_nothing_that_is_sprayed(name: str) -> None:
    dialect, cell = DIALECTS[name], small_cell()
    motion = motion_of("two_tools", True)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()


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
    assert {finding.rule for finding in done.findings} >= {"no-channel"}
    assert any("pressure_bar = 3.500" in text for text in done.files.values())


@NAMED
def test_a_small_program_reads_as_an_integrator_would_want_it(name: str, golden: Callable[[str, str], None]) -> None:
    program = replace(PROGRAMS["loop"](), findings=())
    for file, text in exported(name, program).files.items():
        golden(f"posts/{name}/{file}", text)


@NAMED
@settings(deadline=None, max_examples=15)
@given(program=programs().map(lambda program: native.parse(native.render(program))))  # as a file holds it
def test_any_sound_program_is_read_back_as_planned(name: str, program: TimedProgram) -> None:
    dialect, cell = DIALECTS[name], small_cell()
    motion = make_motion(program, cell, joints_of(program) if dialect.needs_joints else None)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()

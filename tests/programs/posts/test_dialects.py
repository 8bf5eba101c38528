"""What every robot language has to keep to: a dialect is enrolled by standing in ``DIALECTS``."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from installations import bare_cell, small_cell
from robot_programs import PROGRAMS, three_speeds

from programs.events import lower
from programs.export import export
from programs.installation import Installation
from programs.motion import MotionProgram
from programs.posts.compare import compare
from programs.posts.dialects import DIALECTS
from programs.steps import make_motion

CASES = [pytest.param(name, made, id=f"{name}-{made}") for name in DIALECTS for made in PROGRAMS]
NAMED = pytest.mark.parametrize("name", list(DIALECTS))


def motion_of(made: str, cell: Installation) -> MotionProgram:
    return make_motion(PROGRAMS[made](), cell)


@pytest.mark.parametrize(("name", "made"), CASES)
def test_what_is_written_is_read_back_as_planned(name: str, made: str) -> None:
    dialect, cell = DIALECTS[name], small_cell()
    motion = motion_of(made, cell)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()


@pytest.mark.parametrize(("name", "made"), CASES)
def test_every_file_is_ascii_and_no_line_is_too_long(name: str, made: str) -> None:
    exported = export(PROGRAMS[made](), small_cell(), name)
    assert exported.files
    for file, text in exported.files.items():
        assert file.isascii()
        assert "/" not in file
        assert text.isascii()
        assert max(len(line) for line in text.splitlines()) <= DIALECTS[name].longest_line
        assert text.endswith("\n")


@NAMED
def test_the_same_program_gives_the_same_bytes(name: str) -> None:
    once, again = (export(three_speeds(), small_cell(), name).files for _ in range(2))
    assert list(once.items()) == list(again.items())


@NAMED
def test_the_header_says_the_worst_event_error(name: str) -> None:
    exported = export(PROGRAMS["in_flight"](), small_cell(), name)
    said = f"Worst event error {exported.error.distance_mm:.2f} mm, {1e3 * exported.error.time_s:.1f} ms"
    assert any(said in text for text in exported.files.values())


@NAMED
def test_what_the_cell_does_not_map_is_a_comment_and_a_finding(name: str) -> None:
    exported = export(three_speeds(), bare_cell(), name)
    assert {finding.rule for finding in exported.findings} >= {"no-channel"}
    assert any("pressure_bar = 3.500" in text for text in exported.files.values())


@NAMED
def test_a_small_program_reads_as_an_integrator_would_want_it(name: str, golden: Callable[[str, str], None]) -> None:
    program = replace(PROGRAMS["loop"](), findings=())
    for file, text in export(program, small_cell(), name).files.items():
        golden(f"posts/{name}/{file}", text)

from dataclasses import replace

import numpy as np
import pytest
from installations import bare_cell, small_cell
from robot_programs import PROGRAMS, joints_of
from small_programs import DOWN, program_of

from programs.errors import ProgramError
from programs.export import export, find_dialect
from programs.motion.layout import on_time
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait


def rules(program: TimedProgram) -> set[str]:
    return {finding.rule.id for finding in export(program, small_cell("abb"), "abb").findings}


def test_an_unknown_dialect_is_named_with_those_that_exist() -> None:
    with pytest.raises(ProgramError, match="did you mean abb"):
        find_dialect("ABB1")
    with pytest.raises(ProgramError, match="joint-table"):
        find_dialect("cobol")


def test_joint_values_are_asked_for_where_they_are_needed() -> None:
    with pytest.raises(ProgramError, match="track the program"):
        export(PROGRAMS["loop"](), small_cell("abb"), "joint-table")


def test_joints_of_another_program_are_refused() -> None:
    with pytest.raises(ProgramError, match="moves and the cell"):
        export(PROGRAMS["loop"](), small_cell("abb"), "abb", joints_of(PROGRAMS["in_flight"]()))
    with pytest.raises(ProgramError, match="6 joints"):
        export(
            PROGRAMS["loop"](),
            small_cell("abb"),
            "abb",
            on_time(PROGRAMS["loop"](), joints_of(PROGRAMS["loop"]()).joints[:, :3]),
        )


def test_a_program_without_a_move_is_refused() -> None:
    program = program_of(Command(0.0, "FUNCTION", ("clean",), "s"), SetNozzle(0.0, False, "s"))
    with pytest.raises(ProgramError, match="no MOVE"):
        export(program, small_cell("abb"), "abb")


def test_what_the_cell_lacks_is_said_by_name() -> None:
    done = export(PROGRAMS["loop"](), bare_cell("abb"), "abb")
    said = " ".join(finding.message for finding in done.findings)
    for what in ("FUNCTION clean", "SOLUTION saponifier-15", "SET pressure_bar", "resistivity_mohm_cm"):
        assert what in said
    assert all(finding.severity == "warning" for finding in done.findings if finding.rule.id == "no-channel")


def test_a_tilt_band_needs_no_channel() -> None:
    plain = PROGRAMS["loop"]()
    grant = Command(0.0, "SET", ("tilt_band_deg", "5.000"), "s")
    granted = replace(plain, instructions=(grant, *plain.instructions))
    assert export(granted, bare_cell("abb"), "abb").findings == export(plain, bare_cell("abb"), "abb").findings
    assert any("tilt_band_deg = 5.000" in text for text in export(granted, bare_cell("abb"), "abb").files.values())


def test_a_program_that_moves_before_it_names_a_nozzle_is_an_error() -> None:
    program = program_of(
        MoveTo(0.0, (0, 0, 50), DOWN, 0.0, "s"), MoveTo(1.0, (50, 0, 50), DOWN, 50.0, "s"), SetNozzle(1.0, False, "s")
    )
    assert "no-tool" in rules(program)


def test_a_tool_that_the_cell_lacks_is_an_error() -> None:
    program = program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "7"), "s"),
        MoveTo(0.0, (0, 0, 50), DOWN, 0.0, "s"),
        MoveTo(1.0, (50, 0, 50), DOWN, 50.0, "s"),
    )
    assert "no-tool" in rules(program)


def test_a_board_that_is_turned_over_needs_a_place() -> None:
    def flipped(name: str) -> TimedProgram:
        return program_of(
            Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "s"),
            MoveTo(0.0, (0, 0, 50), DOWN, 0.0, "s"),
            Command(0.0, "CALL", (name,), "s"),
            MoveTo(1.0, (50, 0, 50), DOWN, 50.0, "s"),
        )

    assert "no-placement" not in rules(flipped("flip_to_bottom"))
    assert "no-placement" in rules(flipped("flip_to_top"))
    assert "no-placement" not in rules(flipped("take_a_picture"))


def test_waits_and_commands_between_two_moves_stop_the_robot_where_they_are() -> None:
    program = program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "s"),
        MoveTo(0.0, (0, 0, 50), DOWN, 0.0, "s"),
        Wait(1.0, 0.5, "s"),
        Command(2.5, "SET", ("pressure_bar", "2.0"), "s"),
        MoveTo(4.5, (80, 0, 50), DOWN, 20.0, "s"),
    )
    (text,) = export(program, small_cell("abb"), "abb").files.values()
    places = [line.split("[[")[1].split(",")[0] for line in text.splitlines() if "CONST robtarget" in line]
    assert np.array(places, dtype=float).tolist() == [0.0, 20.0, 40.0, 80.0]
    assert text.count(",fine,t_ring60\\WObj:=w_board") == 4


def test_a_move_that_takes_no_time_does_not_break_anything() -> None:
    program = program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "s"),
        MoveTo(0.0, (0, 0, 50), DOWN, 0.0, "s"),
        MoveTo(0.0, (30, 0, 50), DOWN, 0.0, "s"),
        SetNozzle(0.0, True, "s"),
        SetNozzle(0.0, False, "s"),
        MoveTo(1.0, (30, 0, 50), DOWN, 0.0, "s"),
    )
    assert export(program, small_cell("abb"), "abb").files

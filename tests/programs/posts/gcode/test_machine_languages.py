"""Languages of machines whose controller takes tool points: written, read back, corrupted, refused elsewhere."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from random import Random

import pytest
from corruptions import corrupt
from installations import MACHINE_LANGUAGES, WASH, small_cell, small_machine
from robot_programs import PROGRAMS, begin, command, machine_joints_of
from small_plans import LIMITS, plan_of, spray, transfer

from programs.errors import ProgramError
from programs.export import Exported, check_maker, export
from programs.motion.installation import Assignment, Channel, Setting, Valve
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import ReadBoard, ReadCall, ReadLine, ReadReach, ReadTool, Rebuilt
from programs.posts.writing.axes import in_tool_points
from programs.program import TimedProgram
from rulesengine.timing.time_plan import time_plan

CELL = small_machine()
NAMED = pytest.mark.parametrize("name", MACHINE_LANGUAGES)
DIGITAL_M = {"heidenhain": "M402", "fanuc-cnc": "M202", "sinumerik": "$A_OUT[2]=0"}
ON = {
    "heidenhain": r"^.*FUNCTION TCPM .*\n",
    "fanuc-cnc": r"^G43\.4 .*\n",
    "sinumerik": r"^D1\nTRAORI\nORIMKS ORIAXES\nCTOL.*\n",
}
OFF = {"heidenhain": r"^.*FUNCTION RESET TCPM\n", "fanuc-cnc": r"^G49\n", "sinumerik": r"^TRAFOOF\n"}
"""Blocks that switch tool points on and off."""


@cache
def motion_of(made: str) -> MotionProgram:
    program = PROGRAMS[made]()
    return in_tool_points(make_motion(program, CELL, machine_joints_of(program, CELL)), CELL)


@cache
def files_of(name: str, made: str) -> Mapping[str, str]:
    return DIALECTS[name].render(lower(motion_of(made), DIALECTS[name].capability), CELL)


def exported(name: str, made: str) -> Exported:
    program = PROGRAMS[made]()
    return export(program, CELL, name, machine_joints_of(program, CELL))


@NAMED
def test_a_line_is_one_block_and_so_is_a_turn_on_the_spot(name: str) -> None:
    read, straight = (DIALECTS[name].read(files_of(name, made)) for made in ("three_speeds", "loop"))
    assert any(isinstance(step, ReadLine) and step.turn_deg_s and step.speed_mm_s == 0.0 for step in read.steps)
    lines = lower(motion_of("loop"), DIALECTS[name].capability).motion.lines
    assert sum(isinstance(step, ReadLine) for step in straight.steps) == len(lines)


@NAMED
def test_a_small_program_reads_as_an_integrator_would_want_it(name: str, golden: Callable[[str, str], None]) -> None:
    for file, text in exported(name, "loop").files.items():
        golden(f"posts/{name}/{file}", text)


@NAMED
def test_a_jet_that_begins_or_ends_where_the_machine_stands_is_switched_there(name: str) -> None:
    """Its moment would depend on the ramp before the stop, which is the controller's own."""
    forecast = exported(name, "loop").forecast
    assert forecast is not None
    assert any(move.spraying for move in forecast.moves)
    assert forecast.event_mm == pytest.approx(0.0, abs=1e-6)
    assert forecast.event_s == pytest.approx(0.0, abs=1e-6)


@NAMED
def test_no_block_is_a_short_move_while_a_jet_is_on(name: str) -> None:
    forecast = exported(name, "two_tools").forecast
    assert forecast is not None
    assert any(move.spraying for move in forecast.moves)
    assert forecast.short == ()


@NAMED
def test_a_machine_without_tool_points_is_refused_in_a_sentence(name: str) -> None:
    with pytest.raises(
        ProgramError, match=r"is for a machine with X, Y, Z and a head .* kinematics: 5axiskins"
    ) as caught:
        check_maker(DIALECTS[name], small_cell())
    assert "\n" not in str(caught.value)


@NAMED
@pytest.mark.parametrize(("pattern", "message"), [(ON, "takes none"), (OFF, "while tool points are taken")])
def test_tool_points_are_on_for_lines_and_off_for_home_and_tools(
    name: str, pattern: Mapping[str, str], message: str
) -> None:
    lost = {
        file: _renumber(name, re.sub(pattern[name], "", text, flags=re.MULTILINE))
        for file, text in files_of(name, "two_tools").items()
    }
    with pytest.raises(ProgramError, match=message):
        DIALECTS[name].read(lost)


def _renumber(name: str, text: str) -> str:
    if name != "heidenhain":
        return text
    lines = (line.partition(" ")[2] for line in text.splitlines())
    return "".join(f"{number} {line}\n" for number, line in enumerate(lines))


@NAMED
def test_a_valve_that_no_block_can_switch_is_refused(name: str) -> None:
    valve = Valve(Channel("group", "goValve", 4), 0.04, 0.02)
    cell, program = replace(CELL, valves={**CELL.valves, "ring60": valve}), PROGRAMS["in_flight"]()
    joints = machine_joints_of(program, cell)
    if name == "sinumerik":
        assert any("DO $A_DBB[4]=1" in text for text in export(program, cell, name, joints).files.values())
        return
    with pytest.raises(ProgramError, match="goValve is group output 4; while the machine moves only M"):
        export(program, cell, name, joints)


@pytest.mark.parametrize("name", ["heidenhain", "fanuc-cnc"])
@pytest.mark.parametrize("channel", [Channel("digital", "doGripper", 100), Channel("analog", "aoPressure", 120)])
def test_an_output_beyond_those_that_have_a_number_is_refused(name: str, channel: Channel) -> None:
    pressure = Setting(channel, 0.1) if channel.kind == "analog" else CELL.settings["pressure_bar"]
    grips = {grip: (Assignment(channel, 1.0),) if channel.kind == "digital" else () for grip in CELL.grips}
    cell = replace(CELL, settings={**CELL.settings, "pressure_bar": pressure}, grips=grips)
    program = PROGRAMS["two_tools"]()
    with pytest.raises(ProgramError) as caught:
        export(program, cell, name, machine_joints_of(program, cell))
    assert f"{channel.name} is {channel.kind} output {channel.number}; " in str(caught.value)
    assert str(caught.value).endswith("outputs 0 to 99. Give it another number in the cell.")


@pytest.mark.parametrize("routine", ["ab", "if", "shut_valves", "LiftUp.2"])
def test_sinumerik_calls_routines_of_the_integrator_by_names_that_are_free(routine: str) -> None:
    program = calling(routine)
    done = export(program, CELL, "sinumerik", machine_joints_of(program, CELL))
    calls = [step.label for step in done.rebuilt.steps if isinstance(step, ReadCall)]
    assert len(calls) == 1
    assert calls[0].lower() not in ("if", "shut_valves")


def test_sinumerik_refuses_routines_whose_names_do_not_begin_with_two_letters() -> None:
    with pytest.raises(ProgramError, match="CALL p1: names of SINUMERIK's programs begin with two letters"):
        export(calling("p1"), CELL, "sinumerik", machine_joints_of(calling("p1"), CELL))


def calling(routine: str) -> TimedProgram:
    moves = [transfer([[0, 0, 110], [0, 0, 50]]), command("CALL", routine), spray([[0, 0, 50], [40, 0, 50]], 60.0)]
    return time_plan(plan_of(*begin(), *moves), LIMITS)


@NAMED
def test_what_the_frame_waits_for_and_shuts_is_that_of_the_cell(name: str) -> None:
    frame = DIALECTS[name].read(files_of(name, "two_tools")).frame
    assert frame is not None
    assert [wait.timeout_s for wait in frame.waits] == [30.0, 12.5, 20.0]
    assert f"digital {WASH.number}" in frame.shut
    assert frame.guards_override is (None if name == "heidenhain" else True)
    looped = DIALECTS[name].read(files_of(name, "loop")).frame
    assert looped is not None
    assert any(isinstance(step, ReadReach) for part in looped.parts for step in part.entry)


@NAMED
def test_a_valve_that_the_fault_routine_leaves_open_is_found(name: str) -> None:
    files = dict(files_of(name, "two_tools"))
    file = next(each for each in files if each.startswith("shut")) if name == "sinumerik" else next(iter(files))
    begin = max(files[file].find(mark) for mark in ('LBL "shut_valves"', "_SH>\n"))
    at = files[file].index(DIGITAL_M[name], max(begin, 0))
    line_begin, line_end = files[file].rfind("\n", 0, at) + 1, files[file].index("\n", at) + 1
    files[file] = _renumber(name, files[file][:line_begin] + files[file][line_end:])
    try:
        found = [each.message for each in compare(DIALECTS[name].read(files), motion_of("two_tools"), CELL)]
    except ProgramError as refused:
        found = [str(refused)]
    assert any("shut" in message for message in found)


@pytest.mark.slow
@NAMED
def test_random_corruptions_are_found(name: str) -> None:
    random, language, missed, looked = Random(7), DIALECTS[name], list[str](), 0
    for made in ("loop", "two_tools", "in_flight", "three_speeds"):
        files, motion = files_of(name, made), motion_of(made)
        original = language.read(files)
        for _ in range(60):
            changed = corrupt(files, random)
            try:
                read = language.read(changed.files)
                if _done(read) == _done(original):
                    continue
                looked += 1
                if compare(read, motion, CELL) == () and not _is_digit(changed.before, changed.after):
                    missed.append(f"{changed.kind}: {changed.before} -> {changed.after}")
            except ProgramError:
                looked += 1
    assert looked > 60
    assert len(missed) <= 0.01 * looked, missed


def _done(read: Rebuilt) -> tuple[object, ...]:
    """What a text does; a tool, or the frame, may be changed before or after an output at the same place."""
    frames = [step for step in read.steps if isinstance(step, ReadTool | ReadBoard)]
    return [step for step in read.steps if not isinstance(step, ReadTool | ReadBoard)], frames, read.frame, read.homes


def _is_digit(before: str, after: str) -> bool:
    """Whether lines differ by no more than what a text may be off from its plan."""
    numbers = [[float(word) for word in re.findall(r"-?\d+(?:\.\d+)?", line)] for line in (before, after)]
    return len(numbers[0]) == len(numbers[1]) and all(
        abs(a - b) <= max(0.25, 0.011 * abs(a)) for a, b in zip(*numbers, strict=True)
    )

"""The production frame of every language, read back; what is lost or changed in it is found."""

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import pytest
from installations import ARM_LANGUAGES, for_language, small_cell
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line, MotionProgram, Reach
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import ReadLine, ReadReach

FRAMED = [name for name in ARM_LANGUAGES if name != "joint-table"]
NO_GUARD = {"ur", "yaskawa"}
"""Languages that cannot read the speed override."""
NO_QUANTITY = {"yaskawa"}
"""Languages that read no analog input."""
NO_WATCH = {"yaskawa", "denso", "linuxcnc"}
"""Languages that leave watched inputs to the integrator."""
SHUTS = {
    "abb": "SetDO doWash,0;", "abb-paint": "SetBrush 0;", "kuka": "$OUT[1]=FALSE", "ur": "set_out(0, 1, 0)",
    "fanuc": "DO[1]=OFF ;", "yaskawa": "DOUT OT#(1) OFF", "epson": "Off 1, Forced", "denso": "Reset IO[1]",
    "melfa": "M_Out(1)=0", "val3": "do1=false", "linuxcnc": "M65 P1",
}  # fmt: skip
"""What shuts the valve of the first nozzle in the fault routine."""
HANDLER = {
    "abb": r"ERROR\n +shut_valves;", "abb-paint": r"TRAP on_fault\n.*\n +shut_valves;",
    "kuka": r"BRAKE F\nshut_valves\( \)",
    "ur": r"def stop_job\(text\):\n +shut_valves\(\)", "fanuc": r".*IF \(!UO\[3\]\),DO\[1\]=\(OFF\) ;",
    "yaskawa": r"CALL JOB:SHUT_VALVES", "epson": r"Function on_fault\n +Call shut_valves",
    "denso": r"\*Fault:\n +Call shut_valves",
    "melfa": r"\d+ If M_Err=1 Then M_Out\(1\)=0", "val3": r"if isPowered\(\)==false\n.*\n +call shutValves\(\)",
    "linuxcnc": r"o<shut_valves> call",
}  # fmt: skip
"""What calls the fault routine; without its last line the text is refused."""


@cache
def motion_of(made: str, name: str) -> MotionProgram:
    program = PROGRAMS[made]()
    return make_motion(program, cell_of(name), joints_of(program))


def cell_of(name: str) -> Installation:
    return for_language(small_cell(), name)


@cache
def files_of(made: str, name: str) -> Mapping[str, str]:
    return DIALECTS[name].render(lower(motion_of(made, name), DIALECTS[name].capability), cell_of(name))


def problems(made: str, name: str, files: Mapping[str, str]) -> str:
    try:
        found = compare(DIALECTS[name].read(files), motion_of(made, name), cell_of(name))
    except ProgramError as refused:
        return str(refused)
    return "; ".join(map(str, found))


@pytest.mark.parametrize("name", FRAMED)
def test_the_frame_is_read_back_as_the_cell_maps_it(name: str) -> None:
    assert problems("two_tools", name, files_of("two_tools", name)) == ""
    frame = DIALECTS[name].read(files_of("two_tools", name)).frame
    assert frame is not None
    assert frame.guards_override is (None if name in NO_GUARD else True)
    assert len(frame.waits) == (2 if name in NO_QUANTITY else 3)
    assert len(set(frame.shut)) == 2  # two nozzles, two valves
    assert len(frame.parts) > 1


@pytest.mark.parametrize("name", FRAMED)
def test_a_part_is_entered_from_a_high_place_of_the_planned_way(name: str) -> None:
    motion, frame = motion_of("loop", name), DIALECTS[name].read(files_of("loop", name)).frame
    assert frame is not None
    highest = max(step.target.position[2] for step in motion.steps if isinstance(step, Line | Reach))
    for part in frame.parts[1:]:
        moves = [step for step in part.entry if isinstance(step, ReadLine | ReadReach)]
        assert isinstance(moves[0], ReadReach)
        assert all(isinstance(move, ReadLine) for move in moves[1:])
        assert not any(move.signals for move in moves if isinstance(move, ReadLine))
        if name != "linuxcnc":  # which has axes
            assert moves[0].target.position[2] == pytest.approx(highest, abs=0.01)


@pytest.mark.parametrize("name", FRAMED)
def test_a_program_of_many_parts_is_entered_at_each_of_them(name: str) -> None:
    """Some of them have no motion, so that the next one has to be led to."""
    dialect, motion = replace(DIALECTS[name], most_steps=4), motion_of("two_tools", name)
    files = dialect.render(lower(motion, dialect.capability), cell_of(name))
    assert compare(dialect.read(files), motion, cell_of(name)) == ()


def without(files: Mapping[str, str], pattern: str) -> dict[str, str]:
    """Leave out the last line of the first match of a pattern."""
    changed = dict(files)
    for file, text in files.items():
        if match := re.search(pattern, text):
            begin = text.rfind("\n", 0, match.end()) + 1
            changed[file] = text[:begin] + text[text.find("\n", match.end()) + 1 :]
            return changed
    raise AssertionError(pattern)


@pytest.mark.parametrize("name", FRAMED)
def test_a_valve_that_the_fault_routine_does_not_shut_is_found(name: str) -> None:
    files = files_of("loop", name)
    routine = {"yaskawa": "SHUT_VALVES", "fanuc": "WB_SHUT", "melfa": "WBSHUT", "val3": "shutValves"}.get(
        name, "shut_valves"
    )
    begins = {file: text.find(SHUTS[name], _routine(text, routine, file)) for file, text in files.items()}
    file = next(each for each, at in begins.items() if at >= 0 and _routine(files[each], routine, each) >= 0)
    text, at = files[file], begins[file]
    line = text.rfind("\n", 0, at) + 1
    lost = {**files, file: text[:line] + text[text.find("\n", at) + 1 :]}
    assert problems("loop", name, lost)


def _routine(text: str, name: str, file: str) -> int:
    if file.startswith(name):
        return 0
    found = re.search(rf"(PROC|DEF|def|Function|Sub|o<)\s?{name}", text)
    return found.end() if found else len(text)


@pytest.mark.parametrize("name", FRAMED)
def test_a_handler_that_does_not_shut_the_valves_is_found(name: str) -> None:
    assert problems("loop", name, without(files_of("loop", name), HANDLER[name]))


@pytest.mark.parametrize("name", FRAMED)
def test_another_state_time_out_or_least_value_of_a_wait_is_found(name: str) -> None:
    cell = cell_of(name)
    rebuilt = DIALECTS[name].read(files_of("loop", name))
    for at, wait in enumerate(cell.waits):
        others = [replace(wait, timeout_s=wait.timeout_s + 1.0)]
        others += [replace(wait, state=not wait.state)] if wait.contact else [replace(wait, least=wait.least + 0.1)]
        if wait.sensor and name in NO_QUANTITY:
            continue
        for other in others:
            elsewhere = replace(cell, waits=(*cell.waits[:at], other, *cell.waits[at + 1 :]))
            assert compare(rebuilt, motion_of("loop", name), elsewhere)


@pytest.mark.parametrize("name", [name for name in FRAMED if name not in NO_WATCH])
def test_a_text_that_watches_no_input_is_found(name: str) -> None:
    cell, motion = cell_of(name), motion_of("loop", name)
    bare = replace(cell, waits=tuple(replace(wait, watched=False) for wait in cell.waits))
    files = DIALECTS[name].render(lower(motion, DIALECTS[name].capability), bare)
    assert compare(DIALECTS[name].read(files), motion, bare) == ()
    assert any("inputs are watched" in str(each) for each in compare(DIALECTS[name].read(files), motion, cell))


@pytest.mark.parametrize(("name", "shut", "other"), [("fanuc", "DO[2]=(OFF)", "DO[1]=(OFF)"), ("melfa", "(2)", "(1)")])
def test_an_input_without_which_one_valve_stays_open_is_found(name: str, shut: str, other: str) -> None:
    lost = {
        file: re.sub(r"(?m)^.*(?:DI\[4\]|M_In\(4\)).*$", lambda match: match[0].replace(shut, other), text)
        for file, text in files_of("two_tools", name).items()
        if file.endswith((".ls", ".prg"))
    }
    assert lost != files_of("two_tools", name)
    assert problems("two_tools", name, lost)


DECLARED = [
    ("abb", "PERS num nStart:=1;"), ("abb", "VAR bool bLate:=FALSE;"), ("abb", "VAR intnum irFault;"),
    ("abb", "VAR intnum irWatch2;"), ("kuka", "DECL GLOBAL INT tiny_sx45_start=1"), ("kuka", "DECL INT nWait=0"),
    ("ur", "global n_start = 1"), ("epson", "Global Preserve Integer nStart"), ("val3", '<Data name="nStart"'),
]  # fmt: skip
"""Declarations of the frame's variables, without which a controller refuses the program."""


@pytest.mark.parametrize(("name", "declaration"), DECLARED)
def test_a_variable_of_the_frame_that_is_not_declared_is_found(name: str, declaration: str) -> None:
    lines = rf"(?m)^ *{re.escape(declaration)}.*\n" + (r"(?:.*<Value.*\n.*</Data>\n)?" if name == "val3" else "")
    lost = {file: re.sub(lines, "", text) for file, text in files_of("loop", name).items()}
    assert lost != files_of("loop", name)
    assert "declare" in problems("loop", name, lost)


@pytest.mark.parametrize("name", FRAMED)
def test_the_header_states_what_is_waited_for_and_what_is_not(name: str) -> None:
    text = "\n".join(files_of("loop", name).values())
    assert "Waits for part present" in text
    assert re.search(r"Does not wait for temperature", text)
    assert "Set up: " in text


def test_an_entry_that_comes_from_home_at_another_speed_is_found() -> None:
    cell, motion = cell_of("fanuc"), motion_of("loop", "fanuc")
    files = dict(DIALECTS["fanuc"].render(lower(motion, DIALECTS["fanuc"].capability), cell))
    name = next(name for name, text in files.items() if "JMP LBL[99]" in text and "J P[1] 10% FINE" in text)
    files[name] = files[name].replace("J P[1] 10% FINE", "J P[1] 40% FINE", 1)
    found = [each.message for each in compare(DIALECTS["fanuc"].read(files), motion, cell)]
    assert any("the joint motion from home is not at 10 %" in message for message in found), found

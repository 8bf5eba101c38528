import math
import re
from dataclasses import replace

import numpy as np
import pytest
from installations import small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.installation import ArmBranch, Contact, Wait
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Call, Line, MotionProgram, Note, Pause, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.proving.compare import compare
from programs.posts.robots.epson import DIALECT
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram) -> list[str]:
    (text,) = DIALECT.render(lower(motion, DIALECT.capability), small_cell("epson")).values()
    return [line.strip() for line in text.splitlines()]


def moves(motion: MotionProgram) -> list[str]:
    return [line for line in written(motion) if line.startswith("Move")]


def test_the_example_of_the_four_dialects() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    stroke = line(pose(0), pose(100), 100.0, blend_mm=1.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("epson"))
    assert moves(program(*steps)) == [
        "Move XY(100.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1 CP !D4; On 1; D90; Off 1!"
    ]


def test_a_line_too_long_for_whole_percents_is_divided_where_the_signal_leaves() -> None:
    stroke = line(pose(0), pose(900), 100.0, blend_mm=1.0)
    requests = [SwitchRequest(3, 2.085, True, "ring60", "s"), SwitchRequest(3, 6.485, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("epson"))
    text = moves(program(*steps))
    assert [move.partition("!")[2] for move in text] == ["", "D0; On 1!", "D0; Off 1!"]
    assert [move.split("(")[1].split(",")[0] for move in text] == ["204.500", "646.500", "900.000"]
    assert all(" CP" in move for move in text)


def test_no_move_has_more_than_16_percents() -> None:
    stroke = line(pose(0), pose(100), 100.0)
    requests = [SwitchRequest(3, 0.04 * (number + 1), number % 2 == 0, "ring60", "s") for number in range(24)]
    cell = small_cell("epson")
    fast = {"ring60": replace(cell.valves["ring60"], open_lag_s=0.0, close_lag_s=0.0)}
    steps, _ = open_valves((*READY, stroke), requests, replace(cell, valves=fast))
    said = [len(re.findall(r"\bD\d+;", move)) for move in moves(program(*steps))]
    assert max(said) <= 16
    assert sum(said) == 24


def test_a_turn_on_the_spot_goes_at_its_rate() -> None:
    text = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))
    at = next(number for number, line in enumerate(text) if line.endswith("ROT"))
    assert text[at - 1] == "SpeedR 90.0"


def test_frames_are_set_once_and_named_by_number() -> None:
    made = PROGRAMS["bottom"]()
    (text,) = export(made, small_cell("epson"), "epson").files.values()
    assert text.count("TLSet ") == 1
    assert "Local 1, XY(400.000, -120.500, 35.250, 30.0000, 0.0000, 0.0000) ' board as mounted" in text
    assert "Local 2, XY(400.000, 120.000, 60.000, 0.0000, 0.0000, 180.0000) ' flip_to_bottom" in text
    assert " /2" in text


def test_a_tool_number_that_the_controller_lacks_takes_a_free_one() -> None:
    steps = (UseBoard("", IDENTITY, ""), UseTool(40, "a", "s"), Reach(pose(0), (), "s"), UseTool(1, "b", "s"))
    text = written(program(*steps, Reach(pose(0), (), "s")))
    assert [line for line in text if line.startswith("Tool ")] == ["Tool 2", "Tool 1"]


def test_sixteen_tools_are_too_many() -> None:
    tools = [UseTool(number, "a", "s") for number in range(1, 17)]
    with pytest.raises(ProgramError, match="16 tools"):
        written(program(*READY, *tools))


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    (text,) = export(made, small_cell("epson"), "epson", joints_of(made)).files.values()
    lines = [line.strip() for line in text.splitlines()]
    joints = [at for at, line in enumerate(lines) if line.startswith("Go JA(") and "home" not in line]
    assert len(joints) == 3
    assert all(lines[at + 1].startswith("Move XY(") for at in joints)
    assert "Go XY" not in text


def test_a_loop_asks_the_sensor_after_its_first_turn() -> None:
    (text,) = export(PROGRAMS["loop"](), small_cell("epson"), "epson").files.values()
    assert "Loop While nLoop1 < 4 And 2 * AIO_In(1) + 0 < 1" in text
    counted = export(PROGRAMS["loop"](), replace(small_cell("epson"), sensors={}), "epson")
    assert "Loop While nLoop1 < 4\n" in next(iter(counted.files.values()))


def test_a_call_keeps_its_name_and_our_functions_take_others() -> None:
    steps = (*READY, Note("function clean", "s"), Call("tiny__smt_aqueous_01", "s"), line(pose(0), pose(9), 10.0))
    text = written(program(*steps))
    assert "Call tiny__smt_aqueous_01" in text
    assert "Function tiny__smt_aqueous_01" not in text
    assert "Function tiny__smt_aqueous_01_2" in text


@pytest.mark.slow
def test_a_long_program_is_divided_into_files() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines, Pause(0.1, "s"))
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("epson"))
    assert list(files) == [
        "tiny__smt_aqueous.prg",
        "tiny__smt_aqueous_01.prg",
        "tiny__smt_aqueous_02.prg",
        "tiny__smt_aqueous_03.prg",
    ]
    assert compare(DIALECT.read(files), motion, small_cell("epson")) == ()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("SpeedS ", "SpeedT "), (" /1", " /3"), ("On 1", "On"), ("Function main", "Function mine"), ("; Off", ": Off")],
)
def test_the_reader_refuses_what_is_not_written_so(right: str, wrong: str) -> None:
    (text,) = export(PROGRAMS["three_speeds"](), small_cell("epson"), "epson").files.values()
    assert right in text
    with pytest.raises(ProgramError):
        DIALECT.read({"tiny__smt_aqueous.prg": text.replace(right, wrong)})


WATCHED = tuple(Wait(f"w{n}", Contact(f"di{n}", n), True, None, 0.0, 5.0, watched=n > 3) for n in range(1, 9))


def test_traps_are_numbered_by_the_inputs_that_are_watched() -> None:
    watched = WATCHED[:7]
    motion, cell = program(*READY), replace(small_cell("epson"), waits=watched)
    (text,) = DIALECT.render(lower(motion, DIALECT.capability), cell).values()
    assert re.findall(r"Trap (\d), Sw\((\d)\)", text) == [("1", "4"), ("2", "5"), ("3", "6"), ("4", "7")]
    assert compare(DIALECT.read({"tiny__smt_aqueous.prg": text}), motion, cell) == ()
    twice = text.replace("Trap 4, Sw(7)", "Trap 3, Sw(7)")
    with pytest.raises(ProgramError, match="trap 3 is set twice"):
        DIALECT.read({"tiny__smt_aqueous.prg": twice})


def test_more_watched_inputs_than_traps_are_refused() -> None:
    with pytest.raises(ProgramError, match=r"io\.waits\.w8: SPEL\+ watches 4 inputs at most"):
        DIALECT.render(lower(program(*READY), DIALECT.capability), replace(small_cell("epson"), waits=WATCHED))


def test_each_position_states_the_arm_that_the_check_found() -> None:
    """Hand, elbow and wrist, and the turns of J4 and J6; another arm in the text is found."""
    joints = [(0.0, -30.0, 20.0, 10.0, -80.0, 90.0), (0.0, -30.0, 20.0, 190.0, 80.0, -320.0)]
    program_of_joints = PROGRAMS["three_speeds"]()
    cell = replace(small_cell("epson"), branch_at=lambda at: ArmBranch(is_front=at[1] < -0.5, is_above=at[0] < 1.0))
    count = len(joints_of(program_of_joints).joints)
    for values, flags in zip(joints, ("/R /A /NF /J4F0 /J6F0", "/R /A /F /J4F1 /J6F1"), strict=True):
        tracking = replace(joints_of(program_of_joints), joints=np.tile(np.radians(values), (count, 1)))
        motion = make_motion(program_of_joints, cell, tracking)
        files = DIALECT.render(lower(motion, DIALECT.capability), cell)
        text = "".join(files.values())
        assert len(re.findall(r"XY\(.*?\) /R /A", text)) == text.count(f"{flags} /1")
        assert compare(DIALECT.read(files), motion, cell) == ()
        wrong = {file: each.replace(flags, flags.replace("/A", "/B"), 1) for file, each in files.items()}
        (found, *_) = compare(DIALECT.read(wrong), motion, cell)
        assert "the arm is stated as" in found.message


def test_the_arm_of_a_cell_stands_as_makers_name_it() -> None:
    """In front and above at home, and behind where the arm reaches over the first axis."""
    cell = installation_of(read_cell("c8l-bench"))
    assert cell.branch(cell.home) == ArmBranch(is_front=True, is_above=True)
    over = (cell.home[0], math.radians(60.0), math.radians(80.0), *cell.home[3:])
    assert not cell.branch(over).is_front


@pytest.mark.parametrize(
    "name", ["c8l-bench", "gp8-bench", "lrmate-bench", "rv-4frl-bench", "irb1200-bench", "vs060-bench"]
)
def test_library_arms_stand_in_front_and_above_at_home_wherever_they_are_turned(name: str) -> None:
    cell = installation_of(read_cell(name))
    turned = (cell.home[0] + 2.0, *cell.home[1:])
    assert cell.branch(cell.home) == cell.branch(turned) == ArmBranch(is_front=True, is_above=True)

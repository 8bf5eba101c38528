import math
import re
from dataclasses import replace

import pytest
from installations import AIR, WASH, small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.steps import Call, Event, Line, MotionProgram, Note, Pause, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY, Pose
from programs.posts.proving.compare import compare
from programs.posts.robots.melfa import DIALECT

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram) -> dict[str, list[str]]:
    """The steps of each program without their numbers, comments left out."""
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("mitsubishi"))
    return {name: re.findall(r"^\d+ ([^'].*)$", text, flags=re.MULTILINE) for name, text in files.items()}


def test_the_example_of_the_four_dialects() -> None:
    """On 4 mm after the start, off 10 mm before the end: there the line is divided and passed."""
    stroke = line(pose(0), pose(100), 100.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("mitsubishi"))
    said = written(program(*steps))["TINYSMSX4501.prg"]
    assert said[said.index("Spd 100") - 1 : -1] == [
        "Cnt 1,0.3,0.3",
        "Spd 100",
        "Mvs P2",
        "Mvs P3 Wth M_Out(1)=1",
        "Cnt 0",
        "Mvs P4 Wth M_Out(1)=0",
    ]


def test_two_outputs_at_the_same_place_are_both_set() -> None:
    both = tuple(Event(channel, 1.0, "start", 0.0, 0.0, 0.0, 0.0, 60.0, "s") for channel in (WASH, AIR))
    said = written(program(*READY, line(pose(0), pose(60), 60.0, events=both)))["TINYSMSX4501.prg"]
    assert said[-3:-1] == ["M_Out(1)=1", "Mvs P2 Wth M_Out(2)=1"]


def test_what_changes_at_the_end_of_a_passed_line_goes_with_the_next() -> None:
    end = Event(WASH, 0.0, "end", 0.0, 0.0, 1.0, 1.0, 60.0, "s")
    passed = line(pose(0), pose(60), 60.0, blend_mm=1.0, events=(end,))
    said = written(program(*READY, passed, line(pose(60), pose(90), 60.0)))["TINYSMSX4501.prg"]
    assert [step for step in said if step.startswith("Mvs")] == ["Mvs P2", "Mvs P3 Wth M_Out(1)=0"]
    stopped = written(program(*READY, replace(passed, blend_mm=0.0)))["TINYSMSX4501.prg"]
    assert stopped[-3:-1] == ["Mvs P2", "M_Out(1)=0"]


def test_the_base_is_the_robot_seen_from_the_board() -> None:
    board = UseBoard("", Pose((500.0, 0.0, 30.0), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))), "")
    files = DIALECT.render(lower(program(board, *READY[1:]), DIALECT.capability), small_cell("mitsubishi"))
    assert "PBS0=(0.000,500.000,-30.000,0.0000,0.0000,-90.0000)(0,0)" in files["TINYSMSX4501.prg"]
    assert re.findall(r"\d+ (Base P_NBase|Tool P_NTool)", files["TINYSMSX45.prg"]) == ["Base P_NBase", "Tool P_NTool"]


def test_a_turn_on_the_spot_has_the_speed_of_the_controller() -> None:
    said = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))["TINYSMSX4501.prg"]
    assert said[-3:-1] == ["Spd M_NSpd", "Mvs P2"]


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    files = export(made, small_cell("mitsubishi"), "melfa", joints_of(made)).files
    texts = "".join(list(files.values())[1:])
    moves = re.findall(r"\d+ (Mov|Mvs) ([PJ])", texts)
    assert moves.count(("Mov", "J")) == 3
    assert ("Mov", "P") not in moves


def test_a_loop_asks_the_sensor_after_its_first_turn() -> None:
    text = next(iter(export(PROGRAMS["loop"](), small_cell("mitsubishi"), "melfa").files.values()))
    assert "If M1<4 And (0.002*M_Inw(1)+0)<1 Then GoTo *LOOP1" in text
    counted = export(PROGRAMS["loop"](), replace(small_cell("mitsubishi"), sensors={}), "melfa")
    assert "If M1<4 Then GoTo *LOOP1" in next(iter(counted.files.values()))


def test_names_are_capital_letters_and_digits_and_unlike_each_other() -> None:
    calls = [Call(name, "s") for name in ("flip_to_bottom", "flip_to_bottom_again", "clean_01", "start_02")]
    steps = (*READY, *calls, Note("function clean", "s"), line(pose(0), pose(9), 10.0))
    files = DIALECT.render(lower(program(*steps), DIALECT.capability), small_cell("mitsubishi"))
    called = re.findall(r'CallP "(.*)"', "".join(files.values()))
    assert "FLIPTOBOTTOM" in called
    assert "FLIPTOBOTTX2" in called
    assert all(re.fullmatch(r"[A-Z][A-Z0-9]{0,11}", name) for name in called)
    assert len(set(called)) == len(called)


@pytest.mark.slow
def test_a_long_program_is_divided() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines, Pause(0.1, "s"))
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("mitsubishi"))
    assert list(files) == [
        f"{name}.prg" for name in ("TINYSMSX45", "TINYSMSX4501", "TINYSMSX4502", "TINYSMSX4503", "WBSHUT", "WBWATCH")
    ]
    assert max(len(re.findall(r"^\d+ ", text, flags=re.MULTILINE)) for text in files.values()) < 32767
    assert compare(DIALECT.read(files), motion, small_cell("mitsubishi")) == ()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("Wth ", "With "), ("Spd ", "Sped "), ("P2=", "P1002="), ("Base PBS0", "Base J1"), ("\n7 ", "\n70 ")],
)
def test_the_reader_refuses_what_is_not_written_so(right: str, wrong: str) -> None:
    files = dict(export(PROGRAMS["three_speeds"](), small_cell("mitsubishi"), "melfa").files)
    assert any(right in text for text in files.values())
    with pytest.raises(ProgramError):
        DIALECT.read({name: text.replace(right, wrong) for name, text in files.items()})

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
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line, MotionProgram, Pause, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.proving.compare import compare
from programs.posts.robots.yaskawa import DIALECT
from programs.program import Command, MoveTo
from specs.source import Source

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram) -> dict[str, str]:
    return DIALECT.render(lower(motion, DIALECT.capability), small_cell("yaskawa"))


def instructions(text: str, *words: str) -> list[str]:
    return [each for each in text.partition("\nNOP\n")[2].splitlines() if each.startswith(words or "")]


def test_the_example_of_the_four_dialects_with_points_where_the_jet_is_wanted() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    stroke = line(pose(0), pose(100), 100.0, blend_mm=1.5)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("yaskawa"))
    text = written(program(*steps))["TINY__SMT_AQUEOUS_01.JBI"]
    assert instructions(text, "MOVL", "DOUT") == [
        "DOUT OT#(1) OFF",
        "DOUT OT#(2) OFF",
        "MOVL C00001 V=100.0 PL=1 ENWAIT T=0.04",
        "DOUT OT#(1) ON",
        "MOVL C00002 V=100.0 PL=1 ENWAIT T=0.02",
        "DOUT OT#(1) OFF",
        "MOVL C00003 V=100.0 CR=1.5",
    ]
    assert "C00001=8.000,0.000,50.000,180.0000,0.0000,0.0000\n" in text


def test_a_turn_on_the_spot_goes_at_its_rate() -> None:
    text = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))["TINY__SMT_AQUEOUS_01.JBI"]
    assert instructions(text, "MOVL") == ["MOVL C00001 VR=90.0 PL=0"]


def test_a_job_has_one_user_frame_and_names_it() -> None:
    files = export(PROGRAMS["bottom"](), small_cell("yaskawa"), "yaskawa").files
    frames = [re.findall(r"^/{3,4}(?:FRAME )?USER (\d)$", text, re.MULTILINE) for text in files.values()]
    assert [set(each) for each in frames if each] == [{"1"}, {"2"}]
    assert "USER 2 = X 400.000 Y 120.000 Z 60.000 Rx 180.0000" in files["TINY__SMT_AQUEOUS.TXT"]


def test_a_part_after_a_turn_of_the_board_is_entered_by_a_job_in_the_frame_before() -> None:
    """Where the robot is led on by a joint motion whose beginning counts."""
    made, cell = PROGRAMS["bottom"](), small_cell("yaskawa")
    tracking = joints_of(made)
    at = next(step.time_s for step in made.instructions if isinstance(step, Command) and step.keyword == "CALL")
    led = np.array([at < step.time_s < at + 1.0 for step in made.instructions if isinstance(step, MoveTo)])
    motion = make_motion(made, cell, replace(tracking, clock=np.where(led, np.nan, tracking.clock)))
    assert any(step.way for step in motion.steps if isinstance(step, Reach))
    files = written(motion)
    assert compare(DIALECT.read(files), motion, cell) == ()
    (entry,) = (name for name in files if name.endswith("E.JBI"))
    assert "////FRAME USER 1" in files[entry]
    assert "////FRAME USER 2" in files[entry.replace("E.JBI", ".JBI")]


def test_positions_are_counted_and_another_tool_has_a_heading_of_its_own() -> None:
    files = export(PROGRAMS["two_tools"](), small_cell("yaskawa"), "yaskawa").files
    tools = [tool for text in files.values() for tool in re.findall(r"^///TOOL (\d)$", text, re.MULTILINE)]
    assert tools == ["1", "2", "1"]
    for text in files.values():
        if "//POS" in text:
            count = re.findall(r"^///NPOS (\d+),", text, re.MULTILINE)
            assert count == [str(len(re.findall(r"^C\d{5}=", text, re.MULTILINE)))]


def test_turns_beyond_half_a_turn_are_in_the_configuration() -> None:
    joints = tuple(math.radians(angle) for angle in (-190.0, 0.0, 0.0, 200.0, 0.0, 100.0))
    text = written(program(*READY[:2], Reach(pose(0), joints, "s")))["TINY__SMT_AQUEOUS_01.JBI"]
    assert "///RCONF 1,0,0,1,0,1,0,0\n" in text


def test_comments_have_32_characters() -> None:
    odd = replace(
        line(pose(0), pose(9), 10.0), made_by=Source.parse("connectors and a very long path of a recipe/perimeter")
    )
    files = written(program(*READY, odd))
    comments = [each for text in files.values() for each in instructions(text, "'")]
    assert "'connectors and a very long pa..." in comments
    assert max(map(len, comments)) == 33


def test_a_loop_counts_and_says_why() -> None:
    made = export(PROGRAMS["loop"](), small_cell("yaskawa"), "yaskawa")
    assert instructions(made.files["TINY__SMT_AQUEOUS.JBI"], "SET I", "*LOOP", "INC ", "JUMP *LOOP") == [
        "SET I090 0",
        "*LOOP1",
        "INC I090",
        "JUMP *LOOP1 IF I090<4",
    ]
    assert "no-sensor" in {finding.rule.id for finding in made.findings}


@pytest.mark.parametrize("seconds", [0.35, 655.0, 1400.5])
def test_a_long_pause_is_several_timers(seconds: float) -> None:
    motion = program(*READY, Pause(seconds, "s"))
    files = written(motion)
    timers = [float(each.partition("=")[2]) for each in instructions(files["TINY__SMT_AQUEOUS_01.JBI"], "TIMER")]
    assert sum(timers) == pytest.approx(seconds)
    assert max(timers) <= 655.35
    assert compare(DIALECT.read(files), motion, small_cell("yaskawa")) == ()


@pytest.mark.slow
def test_a_long_program_is_divided_into_jobs() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines)
    files = written(motion)
    assert list(files) == [
        "TINY__SMT_AQUEOUS.JBI",
        "TINY__SMT_AQUEOUS_01.JBI",
        "TINY__SMT_AQUEOUS_02.JBI",
        "TINY__SMT_AQUEOUS_03.JBI",
        "SHUT_VALVES.JBI",
        "TINY__SMT_AQUEOUS.TXT",
    ]
    assert compare(DIALECT.read(files), motion, small_cell("yaskawa")) == ()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("TIMER T=", "TIMER "),
        ("DOUT OT#(1) OFF", "DOUT OT#1 OFF"),
        ("///NPOS 1", "///NPOS 2"),
        ("////FRAME USER 1", "////FRAME USER 2"),
        ("///RECTAN", "///PULSE"),
        (" ENWAIT T=0.04\nDOUT", " ENWAIT T=0.04\nNOP\nDOUT"),
    ],
)
def test_the_reader_refuses_what_is_not_inform_as_we_write_it(right: str, wrong: str) -> None:
    files = dict(export(PROGRAMS["three_speeds"](), small_cell("yaskawa"), "yaskawa").files)
    assert any(right in text for text in files.values())
    with pytest.raises(ProgramError):
        DIALECT.read({name: text.replace(right, wrong) for name, text in files.items()})

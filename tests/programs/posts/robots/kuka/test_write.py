import math
import re
from dataclasses import replace

import pytest
from installations import small_cell
from robot_programs import PROGRAMS, joints_of
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Call, Line, MotionProgram, Note, Reach, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY, Pose, Quaternion
from programs.posts.proving.compare import compare
from programs.posts.robots.kuka.read import DIALECT

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))
_HALF = math.sqrt(0.5)


def written(motion: MotionProgram, cell: Installation | None = None) -> dict[str, list[str]]:
    files = DIALECT.render(lower(motion, DIALECT.capability), cell or small_cell("kuka"))
    return {name: text.splitlines() for name, text in files.items()}


def source(motion: MotionProgram) -> list[str]:
    return written(motion)["tiny__smt_aqueous.src"]


def test_the_example_of_the_four_dialects_without_a_division() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    stroke = line(pose(0), pose(100), 100.0, blend_mm=1.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    steps, _ = open_valves((*READY, stroke), requests, small_cell("kuka"))
    lines = source(program(*steps))
    at = lines.index("LIN P2 C_DIS")
    assert lines[at - 3 : at] == [
        "TRIGGER WHEN PATH=-92.00 DELAY=-40 DO $OUT[1]=TRUE",
        "TRIGGER WHEN PATH=-8.00 DELAY=-20 DO $OUT[1]=FALSE",
        "$APO.CDIS=1",
    ]
    assert "$VEL.CP=0.1" in lines


@pytest.mark.slow
@pytest.mark.parametrize("made", list(PROGRAMS))
def test_no_trigger_lies_before_the_motion_that_carries_it(made: str) -> None:
    """The controller would trim it without a word."""
    for each in lower(make_motion(PROGRAMS[made](), small_cell("kuka")), DIALECT.capability).motion.lines:
        for event in each.events:
            leaves_s = each.samples.second_at(event.share) + event.offset_s
            assert -5.1e-4 <= leaves_s <= each.duration_s + 5.1e-4


def test_a_turn_on_the_spot_goes_at_its_rate_and_counts_from_its_end() -> None:
    steps, _ = open_valves(
        (*READY, turn(pose(0), math.pi / 2, 1.0)), [SwitchRequest(3, 0.5, True, "ring60", "s")], small_cell("kuka")
    )
    lines = source(program(*steps))
    at = lines.index("LIN P2")
    assert lines[at - 3 : at] == ["$VEL.ORI1=90", "$VEL.ORI2=90", "TRIGGER WHEN DISTANCE=1 DELAY=-540 DO $OUT[1]=TRUE"]


@pytest.mark.parametrize(
    ("quaternion", "said"),
    [
        ((_HALF, 0.0, 0.0, _HALF), "A 90.0000,B 0.0000,C 0.0000"),
        ((_HALF, 0.0, _HALF, 0.0), "A 0.0000,B 90.0000,C 0.0000"),
        ((_HALF, _HALF, 0.0, 0.0), "A 0.0000,B 0.0000,C 90.0000"),
        ((0.0, 1.0, 0.0, 0.0), "A 0.0000,B 0.0000,C 180.0000"),
    ],
)
def test_a_turns_about_z_b_about_y_c_about_x(quaternion: Quaternion, said: str) -> None:
    there = Reach(Pose((1.0, 2.0, 3.0), quaternion), (), "s")
    data = written(program(*READY[:2], there))["tiny__smt_aqueous.dat"]
    assert f"DECL FRAME P1={{X 1.000,Y 2.000,Z 3.000,{said}}}" in data


def test_with_known_joints_the_arm_is_led_to_its_configuration() -> None:
    made = PROGRAMS["two_tools"]()
    files = export(made, small_cell("kuka"), "kuka", joints_of(made)).files
    lines = files["tiny__smt_aqueous.src"].splitlines()
    led = [at for at, each in enumerate(lines) if each.startswith("PTP {A1 ")]
    assert len(led) == 3
    assert all(any(each.startswith("LIN P") for each in lines[at + 1 : at + 3]) for at in led)
    assert not any(re.fullmatch(r"PTP P\d+", each) for each in lines)


def test_the_first_motion_is_by_joints_even_without_a_home() -> None:
    """The controller runs to its first block only so."""
    lines = written(program(*READY), replace(small_cell("kuka"), home=()))["tiny__smt_aqueous.src"]
    first = next(each for each in lines if each.startswith(("PTP", "LIN")))
    assert first == "PTP $AXIS_ACT"


def test_a_loop_asks_the_sensor_after_each_turn() -> None:
    lines = export(PROGRAMS["loop"](), small_cell("kuka"), "kuka").files["tiny__smt_aqueous.src"].splitlines()
    assert "UNTIL (nLoop1>=4) OR (20*$ANIN[1]+0>=1)" in [each.strip() for each in lines]
    counted = (
        export(PROGRAMS["loop"](), replace(small_cell("kuka"), sensors={}), "kuka")
        .files["tiny__smt_aqueous.src"]
        .splitlines()
    )
    assert "UNTIL nLoop1>=4" in [each.strip() for each in counted]


@pytest.mark.slow
def test_a_long_program_is_divided_into_modules_with_their_own_points() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines)
    files = DIALECT.render(lower(motion, DIALECT.capability), small_cell("kuka"))
    assert list(files)[:4] == [
        "tiny__smt_aqueous.src",
        "tiny__smt_aqueous.dat",
        "tiny__smt_aqueous_01.src",
        "tiny__smt_aqueous_01.dat",
    ]
    assert len(files) == 8
    assert compare(DIALECT.read(files), motion, small_cell("kuka")) == ()


def test_names_have_at_most_24_characters_and_are_unlike_each_other() -> None:
    cell = small_cell("kuka")
    tools = {number: replace(tool, name="a nozzle with a very long name") for number, tool in cell.tools.items()}
    odd = replace(cell, tools=tools)
    motion = make_motion(PROGRAMS["two_tools"](), odd)
    files = DIALECT.render(lower(motion, DIALECT.capability), odd)
    declared = re.findall(r"^DECL (?:GLOBAL )?\w+ (\w+)=", files["tiny__smt_aqueous.dat"], re.MULTILINE)
    assert len({name.lower() for name in declared}) == len(declared)
    assert max(map(len, declared)) <= 24
    assert compare(DIALECT.read(files), motion, odd) == ()


def test_a_call_keeps_its_name_and_our_routines_take_others() -> None:
    steps = (*READY, Note("function clean", "s"), Call("tiny__smt_aqueous_01", "s"), line(pose(0), pose(9), 10.0))
    lines = source(program(*steps))
    assert "tiny__smt_aqueous_01( )" in lines
    assert "DEF tiny__smt_aqueous_01( )" not in lines


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("WAIT SEC ", "WAIT SECS "),
        ("TRIGGER WHEN PATH=", "TRIGGER PATH="),
        ("$OUT[1]=FALSE\n", "$OUT[1]=OFF\n"),
        ("LIN P2\n", "LIN P2000\n"),
        ("C 180.0000}", "C 180.0000"),
    ],
)
def test_the_reader_refuses_what_is_not_krl_as_we_write_it(right: str, wrong: str) -> None:
    files = dict(export(PROGRAMS["three_speeds"](), small_cell("kuka"), "kuka").files)
    assert any(right in text for text in files.values())
    with pytest.raises(ProgramError):
        DIALECT.read({name: text.replace(right, wrong) for name, text in files.items()})


def test_a_source_without_its_data_is_refused() -> None:
    files = dict(export(PROGRAMS["loop"](), small_cell("kuka"), "kuka").files)
    del files["tiny__smt_aqueous.dat"]
    with pytest.raises(ProgramError, match="belong together"):
        DIALECT.read(files)

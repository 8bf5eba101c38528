import math
import re
from dataclasses import replace

import pytest
from installations import RING, small_cell
from robot_programs import PROGRAMS
from robot_steps import line, pose, program, turn

from programs.errors import ProgramError
from programs.export import export
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.steps import EndRepeat, Line, MotionProgram, Pause, Reach, Repeat, Step, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY, Pose
from programs.posts.proving.compare import compare
from programs.posts.robots.fanuc import DIALECT, SLOW_CORNER_S, percent_kept
from specs.source import Source

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def written(motion: MotionProgram, cell: Installation | None = None) -> dict[str, str]:
    return DIALECT.render(lower(motion, DIALECT.capability), cell or small_cell("fanuc"))


def instructions(text: str, word: str = "") -> list[str]:
    found = re.findall(r"^ *\d+:(?:  )?(.*) ;$", text, re.MULTILINE)
    return [each for each in found if each.startswith(word)]


def sprayed(cell: Installation, *jets: tuple[float, bool]) -> MotionProgram:
    stroke = line(pose(0), pose(100), 100.0, blend_mm=1.0)
    requests = [SwitchRequest(3, seconds, spraying, "ring60", "s") for seconds, spraying in jets]
    return program(*open_valves((*READY, stroke), requests, cell)[0])


def test_the_example_of_the_four_dialects_with_points_where_the_jet_is_wanted() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    files = written(sprayed(small_cell("fanuc"), (0.08, True), (0.92, False)))
    assert instructions(files["TISX4501.ls"], "L ") == [
        "L P[2] 100mm/sec CNT100 TB .04sec,DO[1]=ON",
        "L P[3] 100mm/sec CNT100 TB .02sec,DO[1]=OFF",
        "L P[4] 100mm/sec CNT20",
    ]
    assert [x.strip() for x in re.findall(r"X = (.*)  mm,\tY", files["TISX4501.ls"])] == [
        "0.000",
        "8.000",
        "92.000",
        "100.000",
    ]


@pytest.mark.parametrize("lag_s", [0.015, 0.0333, 0.004])
def test_a_lag_between_hundredths_costs_nothing(lag_s: float) -> None:
    """The point moves to where the signal leaves a whole number of hundredths before."""
    valve = replace(RING, open_lag_s=lag_s, close_lag_s=lag_s)
    cell = replace(small_cell("fanuc"), valves={"ring60": valve})
    motion = sprayed(cell, (0.08, True), (0.92, False))
    lowered = lower(motion, DIALECT.capability)
    assert lowered.error.time_s == pytest.approx(DIALECT.capability.cycle_s, abs=1e-6)
    assert compare(DIALECT.read(DIALECT.render(lowered, cell)), motion, cell) == ()


def test_two_signals_before_the_first_jet_are_on_two_motions() -> None:
    valve = replace(RING, open_lag_s=0.2, close_lag_s=0.02, min_pulse_s=0.0)
    cell = replace(small_cell("fanuc"), valves={"ring60": valve})
    motion = sprayed(cell, (0.3, True), (0.31, False))
    files = written(motion, cell)
    timed = [each for each in instructions(files["TISX4501.ls"], "L ") if " TB " in each]
    assert [each.split(",")[1] for each in timed] == ["DO[1]=ON", "DO[1]=OFF"]
    assert compare(DIALECT.read(files), motion, cell) == ()


def test_two_signals_at_one_moment_are_refused() -> None:
    valve = replace(RING, open_lag_s=0.02, close_lag_s=0.02, min_pulse_s=0.0)
    cell = replace(small_cell("fanuc"), valves={"ring60": valve})
    with pytest.raises(ProgramError, match="two outputs change at one moment"):
        written(sprayed(cell, (0.3, True), (0.3, False)), cell)


def test_speeds_are_whole() -> None:
    files = written(program(*READY, line(pose(0), pose(50), 63.6), line(pose(50), pose(90), 20.0)))
    assert [each.split()[2] for each in instructions(files["TISX4501.ls"], "L ")] == ["382cm/min", "20mm/sec"]


def test_a_turn_on_the_spot_goes_at_its_rate() -> None:
    files = written(program(*READY, turn(pose(0), math.pi / 2, 1.0)))
    assert instructions(files["TISX4501.ls"], "L ") == ["L P[2] 90deg/sec FINE"]


def test_straight_on_the_path_is_left_alone_and_a_corner_is_kept_narrow() -> None:
    files = written(
        program(
            *READY,
            line(pose(0), pose(40), 100.0, blend_mm=1.0),
            line(pose(40), pose(80), 50.0, blend_mm=1.0),
            line(pose(80), pose(80, 40), 50.0),
        )
    )
    assert [each.split()[3] for each in instructions(files["TISX4501.ls"], "L ")] == ["CNT100", "CNT40", "FINE"]


def test_frames_are_entered_by_a_program_of_their_own() -> None:
    done = export(PROGRAMS["bottom"](), small_cell("fanuc"), "fanuc")
    files = done.files
    entered = instructions(files["TISX45FR.ls"])
    assert {"UTOOL[1]=PR[91]", "UFRAME[1]=PR[91]", "UFRAME[2]=PR[91]", "PR[91,2]=(-120.5)"} <= set(entered)
    turned = next(each for each in done.handover.frames if (each.kind, each.number) == ("board", 2))
    assert turned.words[:3] == ("400.000", "120.000", "60.000")
    assert not any("TISX45FR" in each for each in instructions(files["TISX45.ls"], "CALL"))


def test_joint_three_counts_from_level_and_the_wrist_and_turns_come_from_the_joints() -> None:
    joints = tuple(math.radians(angle) for angle in (10.0, 20.0, 50.0, -200.0, 30.0, 400.0))
    there = Reach(pose(0), joints, "s")
    text = written(program(*READY[:2], there))["TISX4501.ls"]
    assert re.search(r"J1 = +10\.0000 deg,\tJ2 = +20\.0000 deg,\tJ3 = +30\.0000 deg,\n", text)
    assert "CONFIG : 'F U T, 0, -1, 1'" in text
    assert instructions(text, "J ") + instructions(text, "L ") == ["J P[1] 10% FINE", "L P[2] 100mm/sec FINE"]


def test_the_arm_goes_home_before_and_after() -> None:
    main = instructions(export(PROGRAMS["loop"](), small_cell("fanuc"), "fanuc").files["TISX45.ls"])
    assert [each for each in main if each.startswith(("J ", "CALL", "IF R[89]"))] == [
        "CALL WB_SHUT",
        "J P[1] 10% FINE",
        "IF R[89]<=1,CALL TISX4501",
        "IF R[89]<=2,CALL TISX4502",
        "IF R[89]<=3,CALL TISX4503",
        "J P[1] 10% FINE",
    ]


def test_a_loop_reads_its_input_before_it_jumps() -> None:
    cell = small_cell("fanuc")
    sensor = replace(cell.sensors["resistivity_mohm_cm"], offset=-0.5)
    turns = (Repeat(4, "level", -1.5, sensor, "s"), line(pose(0), pose(9), 10.0), EndRepeat("s"))
    motion = program(*READY, *turns)
    files = written(motion)
    main = instructions(files["TISX45.ls"])
    at = main.index("R[90]=AI[1]*0.01")
    assert main[at + 1 : at + 3] == ["R[90]=R[90]+(-0.5)", "IF R[91]<4 AND R[90]<(-1.5),JMP LBL[1]"]
    assert compare(DIALECT.read(files), motion, cell) == ()


@pytest.mark.parametrize("seconds", [0.0, 0.35, 327.0, 1000.25])
def test_a_long_pause_is_several_waits(seconds: float) -> None:
    motion = program(*READY, Pause(seconds, "s"))
    files = written(motion)
    waits = [float(each[5:-5]) for each in instructions(files["TISX4501.ls"], "WAIT ")]
    assert sum(waits) == pytest.approx(seconds)
    assert max(waits) <= 327.67
    assert compare(DIALECT.read(files), motion, small_cell("fanuc")) == ()


@pytest.mark.slow
def test_a_long_program_is_divided_and_its_names_have_eight_characters() -> None:
    lines: list[Line] = []
    for number in range(2 * DIALECT.most_steps):
        blend_mm = 0.3 if number % 50 else 0.0
        lines.append(line(pose(0.1 * number), pose(0.1 * number + 0.1), 50.0, blend_mm=blend_mm))
    motion = program(*READY, *lines)
    long = replace(motion, origin=replace(motion.origin, board="coldfire mainboard"))
    files = DIALECT.render(lower(long, DIALECT.capability), small_cell("fanuc"))
    names = [name.removesuffix(".ls") for name in files if name.endswith(".ls")]
    (main, *own), shared = names[:-2], names[-2:]
    assert own == [f"{main}{end}" for end in ("01", "02", "03", "FR")]
    assert shared == ["WB_SHUT", "WB_BACK"]
    assert all(len(name) <= 8 for name in names)
    assert compare(DIALECT.read(files), long, small_cell("fanuc")) == ()


def test_remarks_have_32_characters_and_no_semicolon() -> None:
    odd = replace(
        line(pose(0), pose(9), 10.0), made_by=Source.parse("connectors; a very long path of a recipe/perimeter")
    )
    files = written(program(*READY, odd))
    remarks = instructions(files["TISX4501.ls"], "!")
    assert "!connectors, a very long path ..." in remarks
    assert max(map(len, remarks)) == 33


def test_near_gimbal_lock_the_orientation_is_kept() -> None:
    for degrees in (89.99, 89.9999, 90.0, 90.0001, -90.0):
        half = math.radians(degrees) / 2
        there = Pose(
            (0.0, 0.0, 50.0), (math.cos(half) * 0.8, -math.sin(half) * 0.6, math.sin(half) * 0.8, math.cos(half) * 0.6)
        )
        motion = program(*READY[:2], Reach(there, (), "s"))
        assert compare(DIALECT.read(written(motion)), motion, small_cell("fanuc")) == ()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (" ;\n", "\n"),
        ("WAIT ", "WEIT "),
        ("TB .", "TB 1,"),
        ("UF : 1", "UF : 2"),
        ("  mm,\tZ", "  in,\tZ"),
        ("DO[1]=OFF", "DO[1]=0FF"),
    ],
)
def test_the_reader_refuses_what_is_not_tp_as_we_write_it(right: str, wrong: str) -> None:
    files = dict(export(PROGRAMS["three_speeds"](), small_cell("fanuc"), "fanuc").files)
    assert any(right in text for text in files.values())
    with pytest.raises(ProgramError):
        DIALECT.read({name: text.replace(right, wrong) for name, text in files.items()})


@pytest.mark.parametrize("degrees", [90.0, 30.0, 10.0])
@pytest.mark.parametrize("speed_mm_s", [15.0, 40.0])
def test_a_corner_is_cut_by_a_twentieth_of_a_millimetre_however_short_its_lines(
    degrees: float, speed_mm_s: float
) -> None:
    """A parabola that begins a way before a corner stays way sin(angle / 2) / 2 away from it."""
    angle = math.radians(degrees)
    first = line(pose(0), pose(0.3), speed_mm_s, blend_mm=0.11)
    after = line(pose(0.3), pose(0.3 + 0.3 * math.cos(angle), 0.3 * math.sin(angle)), speed_mm_s)
    kept = percent_kept(first, after)
    cut_mm = 0.01 * SLOW_CORNER_S * speed_mm_s * 0.5 * math.sin(0.5 * angle)
    assert kept * cut_mm <= 0.05
    assert kept == 100 or (kept + 1) * cut_mm > 0.05

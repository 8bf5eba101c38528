import math
import re
import shutil
import subprocess
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from installations import RING, small_cell
from numpy.typing import NDArray
from robot_programs import PROGRAMS, joints_of
from robot_steps import program
from waiting import WAIT_S

from programs import foreign
from programs.errors import ProgramError
from programs.export import export
from programs.foreign import rebuild_program
from programs.motion.installation import Channel, Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.samples import SampledLine
from programs.motion.steps import Line, MotionProgram, Reach, Step, Switch, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import Pose, angle, compose, distance, inverse
from programs.posts.gcode.linuxcnc import DIALECT, GROUP_BASE
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import Axes, ReadLine, ReadReach, ReadSwitch, Rebuilt
from programs.posts.writing.axes import in_tool_points
from programs.program import MoveTo, SetNozzle
from robotcell.cell.installation import flange_of, installation_of, to_pose
from robotcell.cell.load import read_cell
from robotcell.robot.robot import flange_poses

LOADED = read_cell("gantry")
GANTRY = replace(installation_of(LOADED), valves={"ring60": RING}, waits=(), tool_point=None)
"""Joints X, Y, Z, C, B. It waits for nothing: the interpreter alone, without a controller, reads 0 at all inputs."""
NEEDS_RS274 = pytest.mark.skipif(
    shutil.which("rs274") is None, reason="LinuxCNC's interpreter (rs274 of Debian's linuxcnc-uspace) is not installed"
)
DEGREES = np.array([1.0, 1.0, 1.0, math.pi / 180, math.pi / 180])


def tip(axes: NDArray[np.float64]) -> Pose:
    """The orifice of tool 1 seen from the board, for axes in mm and degrees."""
    joints = np.atleast_2d(axes) * DEGREES * [1e-3, 1e-3, 1e-3, 1.0, 1.0]
    flange = to_pose(flange_poses(LOADED.cell.robot, joints)[0])
    return compose(inverse(GANTRY.T_base_board), compose(flange, GANTRY.tools[1].T_flange_tcp))


def stroke(begin: list[float], end: list[float], speed: float, *, blend_mm: float = 0.0) -> Line:
    """The orifice goes straight from x, y, z to x, y, z of the board while C and B go from angle to angle."""
    way, samples = np.array([begin, end]), 201
    shares = np.linspace(0.0, 1.0, samples)
    asked = way[0] + shares[:, None] * (way[1] - way[0])
    axes = asked.copy()
    for row, wanted in zip(axes, asked, strict=True):
        row[:3] = 0.0
        row[:3] = wanted[:3] - tip(row).position  # the board is not turned in the base
    poses = [tip(axes[0]), tip(axes[-1])]
    length = float(np.linalg.norm(way[1, :3] - way[0, :3]))
    turn = math.radians(float(np.abs(way[1, 3:] - way[0, 3:]).sum()))
    seconds = length / speed if length else turn / math.radians(speed)
    samples = SampledLine(shares * seconds, shares, axes * DEGREES)
    return Line(*poses, speed if length else 0.0, turn / seconds, blend_mm, samples, 0.0, "s/line")


def begun(*lines: Line) -> MotionProgram:
    joints = tuple(lines[0].samples.joints[0].tolist())
    ready: tuple[Step, ...] = (
        UseBoard("", GANTRY.T_base_board, ""),
        UseTool(1, "ring60", "s"),
        Reach(lines[0].start, joints, "s"),
    )
    requests = [
        SwitchRequest(3, 0.25 * lines[0].duration_s, True, "ring60", "s"),
        SwitchRequest(3, 0.6, False, "ring60", "s"),
    ]
    return program(*open_valves((*ready, *lines), requests, GANTRY)[0])


TILTED = [
    stroke([0, 0, 40, -90, 0], [100, 0, 40, -90, 0], 100.0, blend_mm=1.0),
    stroke([100, 0, 40, -90, 0], [100, 60, 40, 0, 0], 40.0, blend_mm=1.0),
    stroke([100, 60, 40, 0, 0], [20, 60, 40, 0, 45], 60.0),
    stroke([20, 60, 40, 0, 45], [20, 60, 40, 180, 45], 90.0),
]
"""Plain, turning C, tilting B, and a turn of C while the nozzle is tilted: the carriage moves, not the tip."""


def text_of(motion: MotionProgram, cell: Installation = GANTRY) -> str:
    return next(iter(DIALECT.render(lower(motion, DIALECT.capability), cell).values()))


def beside_shut(text: str) -> dict[str, str]:
    """A program and the file of what shuts the valves, which calls it at an abort too."""
    shut = "".join(f"  M65 P{number}\n" for number in range(8))
    return {"tiny.ngc": text, "shut_valves.ngc": f"o<shut_valves> sub\n{shut}o<shut_valves> endsub\n\nM2\n"}


@pytest.mark.slow
def test_a_gantry_is_read_back_as_planned_and_its_tip_keeps_to_its_lines() -> None:
    motion = begun(*TILTED)
    read = DIALECT.read(beside_shut(text_of(motion)))
    assert compare(read, motion, GANTRY) == ()
    at = np.array(next(step.target.values for step in read.steps if isinstance(step, ReadReach)))
    lines = list(TILTED)
    for step in read.steps:
        if not isinstance(step, ReadLine):
            continue
        to = np.array(step.target.values)
        half_way = np.array(tip(0.5 * (at + to)).position)
        start, end = (np.array(pose.position) for pose in (lines[0].start, lines[0].target))
        along = np.clip((half_way - start) @ (end - start) / max((end - start) @ (end - start), 1e-9), 0, 1)
        assert np.linalg.norm(start + along * (end - start) - half_way) <= 0.01
        if step.duration_s is not None and lines[0].speed_mm_s:
            way = math.dist(tip(at).position, tip(to).position)
            assert way / step.duration_s == pytest.approx(lines[0].speed_mm_s, rel=0.01)
        at = to
        if math.dist(tip(to).position, end) < 1e-3 and abs(to - lines[0].joints / DEGREES).max() < 1e-3:
            lines.pop(0)
    assert not lines


@pytest.mark.parametrize("takes_tool_points", [False, True])
def test_a_program_is_shown_by_the_kinematics_of_its_cell(takes_tool_points: bool) -> None:
    cell = replace(GANTRY, tool_point=installation_of(LOADED).tool_point if takes_tool_points else None)
    motion = begun(*TILTED)
    files = beside_shut(text_of(in_tool_points(motion, cell) if takes_tool_points else motion, cell))
    shown = rebuild_program("linuxcnc", files, cell, flange_of(LOADED.cell))
    moves = [item for item in shown.instructions if isinstance(item, MoveTo)]
    poses = [Pose(move.position, move.quaternion) for move in moves]
    for line in motion.lines:
        apart = min(distance(line.target, pose) + 10.0 * angle(line.target, pose) for pose in poses)
        assert apart <= 0.01
    ways = [abs(pose.position[2] - 40.0) for pose in poses]
    assert max(ways) <= 0.05  # between the ends too
    lasting = sum(line.length_mm / line.speed_mm_s for line in motion.lines[:3]) + motion.lines[3].duration_s
    assert shown.totals.duration_s == pytest.approx(lasting, rel=0.02)
    assert [item.spraying for item in shown.instructions if isinstance(item, SetNozzle)] == [True, False]


def test_a_program_of_axes_is_not_shown_without_its_cell() -> None:
    files = beside_shut(text_of(begun(*TILTED)))
    with pytest.raises(ProgramError, match=r"tiny.ngc:\d+: this program moves 5 axes, whose poses the kinematics"):
        rebuild_program("linuxcnc", files, GANTRY)
    fewer = replace(GANTRY, joints=GANTRY.joints[:4])
    with pytest.raises(ProgramError, match="moves 5 axes, and the cell has 4; read it in the cell"):
        rebuild_program("linuxcnc", files, fewer, flange_of(LOADED.cell))


def test_endless_turns_are_refused_before_they_are_divided(monkeypatch: pytest.MonkeyPatch) -> None:
    text = text_of(begun(*TILTED))
    files = beside_shut(re.sub(r"(G0 .* C)\S+", r"\g<1>9999999", text, count=1))
    assert files["tiny.ngc"] != text
    with pytest.raises(ProgramError, match=r"tiny.ngc:\d+: an axis turns to more than 50,000 degrees"):
        rebuild_program("linuxcnc", files, GANTRY, flange_of(LOADED.cell))
    monkeypatch.setattr(foreign, "MOST_MOVES", 10)
    with pytest.raises(ProgramError, match=r"tiny.ngc:\d+: up to this statement there are more than 10 moves"):
        rebuild_program("linuxcnc", beside_shut(text), GANTRY, flange_of(LOADED.cell))


def test_a_stroke_that_does_not_turn_has_the_speed_of_the_orifice_in_mm_per_minute() -> None:
    text = text_of(begun(TILTED[0]))
    feeds = re.findall(r"^.*G1 .*$", text, flags=re.MULTILINE)
    assert [line.split()[-1] for line in feeds] == ["F6000"] * len(feeds)
    assert "G93" not in text.split("o<tiny__smt_aqueous_01> sub")[1]


def test_under_5axiskins_lines_and_turns_on_the_spot_are_one_block_in_tool_points() -> None:
    cell = replace(GANTRY, tool_point=installation_of(LOADED).tool_point)
    motion = in_tool_points(begun(*TILTED), cell)
    text = text_of(motion, cell)
    assert compare(DIALECT.read(beside_shut(text)), motion, cell) == ()
    blocks = re.findall(r"^.*G1 .*$", text, flags=re.MULTILINE)
    assert len(blocks) == 4 + 2  # the valve's signals divide lines
    assert "G93" not in text
    assert blocks[-1] == "G1 C180.0000 F5400"
    assert [re.search(r"X(-?[\d.]+)", block)[1] for block in blocks if "X" in block][-1] == "20.0000"
    assert "G10 L2 P1 X-80 Y-50 Z-110 C0 B0 R0" in text
    assert "5axiskins; pivot-length 180" in text


def test_the_origin_of_the_board_is_the_zero_of_a_gantry() -> None:
    text = text_of(begun(TILTED[0]))
    assert "G10 L2 P1 X-80 Y-50 Z60 C0 B0 R0" in text
    moved = replace(GANTRY, T_base_board=Pose((10.0, 20.0, 60.0), (1.0, 0.0, 0.0, 0.0)))
    shift = np.array([90.0, 70.0, 0.0, 0.0, 0.0])
    line = replace(TILTED[0], samples=replace(TILTED[0].samples, joints=TILTED[0].samples.joints + shift))
    board = UseBoard("", moved.T_base_board, "")
    steps = [board if isinstance(step, UseBoard) else step for step in begun(line).steps]
    other = text_of(program(*steps), moved)
    assert "G10 L2 P1 X10 Y20 Z60 C0 B0 R0" in other
    assert other.replace("X10 Y20 Z60", "X-80 Y-50 Z60") == text


def test_outputs_change_in_step_with_the_block_that_follows() -> None:
    lines = text_of(begun(TILTED[0])).splitlines()
    for word in ("M62 P1", "M63 P1"):
        assert re.search(r"\bG1 ", lines[lines.index(word) + 1])
    assert not [line for line in lines if line.startswith("M64")]


def test_at_rest_outputs_change_at_once_and_groups_have_analog_numbers() -> None:
    channels = [Channel("digital", "d", 7), Channel("analog", "a", 1), Channel("group", "g", 2)]
    switches = [Switch(channel, 1.0, "s") for channel in channels]
    text = text_of(program(*switches))
    assert [line for line in text.splitlines() if line.startswith("M6")] == ["M64 P7", "M68 E1 Q1", "M68 E34 Q1"]
    assert "(Output g: motion.analog-out-34 [a whole number])" in text


@pytest.mark.parametrize(
    "channel", [Channel("digital", "d", 64), Channel("group", "g", 32), Channel("analog", "a", -1)]
)
def test_outputs_that_linuxcnc_does_not_have_are_refused(channel: Channel) -> None:
    with pytest.raises(ProgramError, match=channel.name):
        text_of(program(Switch(channel, 1.0, "s")))


def test_without_the_joint_motion_there_is_no_program() -> None:
    with pytest.raises(ProgramError, match="track"):
        export(PROGRAMS["loop"](), small_cell(), "linuxcnc")


def test_axes_off_the_planned_motion_are_found() -> None:
    motion = begun(*TILTED)
    text = text_of(motion)
    blocks = [line for line in text.splitlines() if "G1 X" in line and " C" in line]
    block = blocks[len(blocks) // 2]
    value = re.findall(r"X(\d+\.\d+)", block)[0]
    off = text.replace(block, block.replace(f"X{value}", f"X{float(value) + 0.02:.4f}"))
    assert compare(DIALECT.read(beside_shut(off)), motion, GANTRY)


@pytest.mark.parametrize(
    ("right", "wrong"), [(r"(?m)^G0 .*\n", ""), (r"(?m)^(G0 X\S+) .*", r"\1"), (r" B-?[\d.]+", "")]
)
def test_blocks_of_other_axes_than_the_machine_has_are_found(right: str, wrong: str) -> None:
    motion = begun(*TILTED)
    text = re.sub(right, wrong, text_of(motion))
    assert text != text_of(motion)
    try:
        found = compare(DIALECT.read(beside_shut(text)), motion, GANTRY)
    except ProgramError:
        return
    assert found


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("G61.1 ", "G61.2 "), ("G54\n", "G92\n"), ("G21 G90", "G20 G90"), ("M62 P1", "M62 P1 Q1")],
)
def test_the_reader_refuses_what_is_not_written_so(right: str, wrong: str) -> None:
    text = text_of(begun(*TILTED))
    assert right in text
    with pytest.raises(ProgramError):
        DIALECT.read(beside_shut(text.replace(right, wrong)))


@pytest.mark.parametrize("made", ["two_tools", "bottom", "in_flight"])
def test_what_is_set_at_once_waits_for_the_end_of_the_motion_before(made: str) -> None:
    """The task controller runs ahead of the motion where it has time; starved, it has shut a valve before its place."""
    program = PROGRAMS[made]()
    (text, _) = export(program, small_cell(), "linuxcnc", joints_of(program)).files.values()
    blocks = [block.strip() for block in text.splitlines() if not block.startswith("(")]
    for before, block in pairwise(blocks):
        if block.startswith(("M64 ", "M65 ", "M68 ")):
            assert before.startswith(("G4 P0.001", "M64 ", "M65 ", "M68 "))
    assert "G4 P0.001" in blocks


# LinuxCNC's own interpreter


def test_a_part_may_have_other_statements_than_its_call() -> None:
    program = PROGRAMS["loop"]()
    (file, text), (shut, shuts) = export(program, small_cell(), "linuxcnc", joints_of(program)).files.items()
    edited = text.replace("  o<tiny__smt_aqueous_01> call\n", "  o<tiny__smt_aqueous_01> call\n  M65 P60\n", 1)
    plain, read = (DIALECT.read({file: each, shut: shuts}) for each in (text, edited))
    (added,) = [at for at, step in enumerate(read.steps) if step == ReadSwitch("digital 60", 0.0)]
    assert (*read.steps[:added], *read.steps[added + 1 :]) == plain.steps
    doubled = edited.replace("  M65 P60\no201 endif", "  M65 P60\no201 endif\no201 endif", 1)
    with pytest.raises(ProgramError, match="ends another condition than the innermost"):
        DIALECT.read({file: doubled, shut: shuts})


def interpret(files: dict[str, str], folder: Path) -> list[str]:
    """The canonical machining functions that LinuxCNC calls for a program."""
    for name, text in files.items():
        (folder / name).write_text(text)
    (folder / "flip_to_bottom.ngc").write_text("o<flip_to_bottom> sub\no<flip_to_bottom> endsub\nM2\n")
    (folder / "tool.tbl").write_text("T1 P1\nT2 P2\n")
    command = ["rs274", "-g", "-t", "tool.tbl", next(iter(files))]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=WAIT_S, check=False)
    assert done.returncode == 0, done.stderr
    calls = re.findall(r"^ *\d+ N\.+ *(.*)$", done.stdout, flags=re.MULTILINE)
    assert "PROGRAM_END()" in calls, done.stdout[-500:] + done.stderr
    return calls


def canonical(calls: list[str]) -> list[tuple[str, tuple[float, ...]]]:
    """Motions in machine coordinates (X, Y, Z, A, B, C), and outputs."""
    zero, found = np.zeros(6), list[tuple[str, tuple[float, ...]]]()
    for call in calls:
        word, _, rest = call.partition("(")
        numbers = [float(each) for each in re.findall(r"-?\d+\.?\d*", rest)]
        if word == "SET_G5X_OFFSET":
            zero = np.array(numbers[1:7])
        elif word in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            found.append((word, tuple(np.array(numbers) + zero)))
        elif re.fullmatch(r"(SET|CLEAR)_(MOTION|AUX)_OUTPUT_\w+", word):
            value = numbers[1] if "VALUE" in word else float(word.startswith("SET"))
            found.append(("OUTPUT", (numbers[0], value)))
    return found


def expected(read: Rebuilt, letters: str) -> list[tuple[str, tuple[float, ...]]]:
    """The same of a program that was read; it shuts its valves first."""
    assert read.frame is not None
    found = list[tuple[str, tuple[float, ...]]]()
    for step in (*(ReadSwitch(valve, 0.0) for valve in read.frame.shut), *read.steps):
        if isinstance(step, ReadSwitch):
            kind, number = step.channel.split()
            found.append(("OUTPUT", (int(number) + (GROUP_BASE if kind == "group" else 0), step.value)))
        elif isinstance(step, ReadLine | ReadReach):
            assert isinstance(step.target, Axes)
            at = dict(zip(letters, step.target.values, strict=True))
            word = "STRAIGHT_FEED" if isinstance(step, ReadLine) else "STRAIGHT_TRAVERSE"
            found.append((word, tuple(at.get(letter, 0.0) for letter in "XYZABC")))
    return found


def assert_same(calls: list[tuple[str, tuple[float, ...]]], read: list[tuple[str, tuple[float, ...]]]) -> None:
    assert [word for word, _ in calls] == [word for word, _ in read]
    for (_, called), (_, planned) in zip(calls, read, strict=True):
        np.testing.assert_allclose(called, planned, atol=2e-4)


@NEEDS_RS274
@pytest.mark.parametrize("made", ["three_speeds", "short_strokes", "in_flight", "two_tools", "bottom"])
def test_linuxcnc_accepts_the_program_and_does_what_our_reader_reads(made: str, tmp_path: Path) -> None:
    plan, cell = PROGRAMS[made](), replace(small_cell(), home=(), waits=())
    motion = make_motion(plan, cell, joints_of(plan))
    files = DIALECT.render(lower(motion, DIALECT.capability), cell)
    assert_same(canonical(interpret(files, tmp_path)), expected(DIALECT.read(files), "XYZABC"))


@pytest.mark.slow
@NEEDS_RS274
def test_linuxcnc_moves_the_gantry_as_planned_and_at_the_planned_speed(tmp_path: Path) -> None:
    cell, motion = replace(GANTRY, home=()), begun(*TILTED)
    files = beside_shut(text_of(motion, cell))
    calls = interpret(files, tmp_path)
    moves = canonical(calls)
    assert_same(moves, expected(DIALECT.read(files), "XYZCB"))
    at = np.array(next(values for word, values in moves if word == "STRAIGHT_TRAVERSE"))
    feed, checked, zero = 0.0, 0, np.array([-80.0, -50.0, 60.0, 0.0, 0.0, 0.0])
    for call in calls:
        numbers = [float(each) for each in re.findall(r"-?\d+\.?\d*", call.partition("(")[2])]
        if call.startswith("SET_FEED_RATE"):
            feed = numbers[0]
        elif call.startswith("STRAIGHT_FEED"):
            to = np.array(numbers) + zero
            carriage = math.dist(at[:3], to[:3])  # what LinuxCNC's F is about where X, Y or Z moves
            way = math.dist(tip(at[[0, 1, 2, 5, 4]]).position, tip(to[[0, 1, 2, 5, 4]]).position)
            speed = way / (carriage / feed * 60.0)
            if way > 0.05 and carriage > 0.05:
                assert min(abs(speed / line.speed_mm_s - 1.0) for line in TILTED if line.speed_mm_s) < 0.01
                checked += 1
            at = to
    assert checked > 20


@NEEDS_RS274
def test_linuxcnc_repeats_a_loop_while_the_input_shows_too_little(tmp_path: Path) -> None:
    plan, cell = PROGRAMS["loop"](), replace(small_cell(), waits=())
    once = replace(make_motion(plan, cell, joints_of(plan)), findings=())
    lines = [step for step in once.steps if isinstance(step, Line)]
    calls = interpret(dict(DIALECT.render(lower(once, DIALECT.capability), cell)), tmp_path)
    ends = [call for call in calls if call.startswith("SET_MOTION_CONTROL_MODE(CANON_EXACT_STOP")]
    assert sum(call.startswith("DWELL") and "0.001" not in call for call in calls) == 4  # the input reads 0 here
    assert len(ends) >= 2 + 3 * 4
    assert len(lines) == 6


@NEEDS_RS274
def test_linuxcnc_finds_the_files_of_a_long_program(tmp_path: Path) -> None:
    short = replace(DIALECT, most_steps=4)
    plan, cell = PROGRAMS["in_flight"](), replace(small_cell(), home=(), waits=())
    files = short.render(lower(make_motion(plan, cell, joints_of(plan)), DIALECT.capability), cell)
    assert len(files) > 3
    assert_same(canonical(interpret(files, tmp_path)), expected(DIALECT.read(files), "XYZABC"))

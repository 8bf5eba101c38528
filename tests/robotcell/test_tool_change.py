"""A tool with another TCP: the orifice jumps when the tool is changed, the arm does not."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from installations import ARM_LANGUAGES
from robot_programs import two_tools
from small_cells import TWO_TCPS
from small_programs import program_of
from tracked import HEIGHT, line_program, moves_of

import robotcell.track
from boards.load import load_board
from programs import native
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line, MotionProgram, Reach, Switch, UseTool
from programs.playback import playback
from programs.pose import Pose, angle, distance
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.program import Command, Instruction, MoveTo, SetNozzle, TimedProgram, Wait
from reports.files.robot_programs import tracking_of
from robotcell.cell.installation import installation_of, to_pose
from robotcell.cell.load import read_cell_text
from robotcell.motion.cell_queries import build_queries
from robotcell.robot.robot import flange_poses, inverse
from robotcell.track import CellReport, Terms, track

LOADED = read_cell_text(TWO_TCPS)
CELL = LOADED.cell
VALVES = {valve.channel.name for valve in installation_of(LOADED).valves.values()}
TERMS = Terms(round_nozzles=frozenset({"ring60"}))


@cache
def tracked() -> CellReport:
    return track(two_tools(), CELL, None, terms=TERMS)


@cache
def installed() -> Installation:
    return installation_of(LOADED)


def motion_of(report: CellReport) -> MotionProgram:
    return make_motion(report.program, installed(), tracking_of(report))


def tools_of(program: TimedProgram) -> list[int]:
    """The tool that is carried at each move."""
    tools: list[int] = []
    carried = 0
    for item in program.instructions:
        if isinstance(item, Command) and item.keyword == "NOZZLE":
            carried = int(item.arguments[2])
        elif isinstance(item, MoveTo):
            tools.append(carried)
    return tools


def seen(q: tuple[float, ...], tool: int) -> Pose:
    """Where joints bring the orifice of a tool, in the board frame."""
    base = inverse(CELL.T_cell_board) @ CELL.T_cell_base
    tcp = next(each.T_flange_tcp for each in CELL.tools if each.number == tool)
    return to_pose(base @ flange_poses(CELL.robot, np.array([q]))[0] @ tcp)


@pytest.mark.slow
def test_joints_and_poses_agree_with_the_tool_that_is_carried() -> None:
    report = tracked()
    assert report.possible
    moves, tools = moves_of(report.program), tools_of(report.program)
    assert set(tools) == {1, 2}
    for move, tool, q in zip(moves, tools, report.joints.tolist(), strict=True):
        there = seen(tuple(q), tool)
        assert distance(there, Pose(move.position, move.quaternion)) < 1e-3
        assert angle(there, Pose(move.position, move.quaternion)) < 1e-5


def test_the_orifice_jumps_and_the_joints_do_not() -> None:
    report = tracked()
    moves, tools = moves_of(report.program), tools_of(report.program)
    changes = np.flatnonzero(np.diff(tools)) + 1
    assert len(changes) == 2
    for at in changes.tolist():
        np.testing.assert_allclose(report.joints[at], report.joints[at - 1], atol=1e-9)
        assert moves[at].time_s == pytest.approx(moves[at - 1].time_s)
        assert np.linalg.norm(np.subtract(moves[at].position, moves[at - 1].position)) > 50


def test_what_the_controller_is_told_is_where_the_arm_is() -> None:
    """Every reach and every line ends where its joints bring the orifice of the tool in use, and begins so too."""
    tool = 0
    for step in motion_of(tracked()).steps:
        if isinstance(step, UseTool):
            tool = step.number
        elif isinstance(step, Reach):
            assert distance(seen(step.joints, tool), step.target) < 1e-3
        elif isinstance(step, Line):
            for q, pose in ((step.samples.joints[0], step.start), (step.samples.joints[-1], step.target)):
                assert distance(seen(tuple(q.tolist()), tool), pose) < 1e-3


def test_the_tool_is_changed_at_its_place_and_nothing_is_sprayed_on_the_way() -> None:
    """Up to the height at which the program begins, home with the one tool, and from there with the other."""
    steps = [step for step in motion_of(tracked()).steps if isinstance(step, Reach | UseTool | Line)]
    home = tuple(CELL.home.tolist())
    changes = [at for at, step in enumerate(steps) if isinstance(step, UseTool)][1:]
    assert len(changes) == 2
    for at in changes:
        lifted, before, after = steps[at - 2], steps[at - 1], steps[at + 1]
        assert isinstance(lifted, Reach | Line)
        assert lifted.target.position[2] == pytest.approx(110.0)
        assert isinstance(before, Reach)
        assert isinstance(after, Reach)
        assert before.joints == pytest.approx(home)
        assert after.joints == pytest.approx(home)
    report = tracked()
    states = playback(report.program, np.array([move.time_s for move in moves_of(report.program)]))
    at_home = np.abs(report.joints - CELL.home).max(axis=1) < 1e-9
    assert at_home.sum() >= 6
    assert not states.spraying[at_home].any()


def test_a_jet_that_goes_on_across_a_change_is_shut_on_the_way() -> None:
    program = two_tools()
    off = next(at for at, item in enumerate(program.instructions) if isinstance(item, SetNozzle) and not item.spraying)
    kept = tuple(item for at, item in enumerate(program.instructions) if at not in (off, off + 5))
    report = track(replace(program, instructions=kept), CELL, None, terms=TERMS)
    ways, is_open, opened = 0, {0.0}, 0
    for step in motion_of(report).steps:
        if isinstance(step, Switch):
            is_open = {step.value} if step.channel.name in VALVES else is_open
        elif isinstance(step, Line):
            values = [event.value for event in step.events if event.channel.name in VALVES]
            opened += 1.0 in values
            is_open = {values[-1]} if values else is_open
        elif isinstance(step, Reach) and step.way:
            ways += 1
            assert is_open == {0.0}
    assert ways >= 6
    assert opened


@pytest.mark.slow
def test_a_place_above_the_board_is_a_warning_and_one_beside_it_is_not() -> None:
    board = load_board(Path("tiny"))
    beside = CELL.home + np.array([-0.6, 0.0, 0.0, 0.0, 0.0, 0.0])
    done, program = tracked(), moves_of(tracked().program)
    inside = (at for at, move in enumerate(program) if 5 < move.position[0] < 15 and 5 < move.position[1] < 15)
    above = done.joints[next(inside)]
    for place, expected in ((None, False), (above, True), (beside, False)):
        cell = replace(CELL, tool_change=place)
        report = track(two_tools(), cell, board, terms=TERMS)
        found = [finding for finding in report.findings if finding.rule.id == "tool-change-above-board"]
        assert len(found) == expected
        assert all("tool_change_deg_mm of cell" in finding.message for finding in found)


def test_another_place_for_the_tools_is_gone_to() -> None:
    place = CELL.home + np.array([-0.6, 0.0, 0.0, 0.0, 0.0, 0.0])
    report = track(two_tools(), replace(CELL, tool_change=place), None, terms=TERMS)
    tools = tools_of(report.program)
    for at in (np.flatnonzero(np.diff(tools)) + 1).tolist():
        np.testing.assert_allclose(report.joints[at], place, atol=1e-9)
    np.testing.assert_allclose(report.joints[[0, -1]], [CELL.home, CELL.home], atol=1e-9)
    assert report.added.tool_changes > tracked().added.tool_changes


def test_a_place_that_is_not_clear_is_refused_before_any_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every way leads there: no search could find another. The place is the user's: no remedy is looked for."""
    monkeypatch.setattr(robotcell.track, "plan_motion", None)
    low = CELL.home + np.array([0.0, 0.0, 1.2, 0.0, 0.0, 0.0])
    queries = build_queries(two_tools(), CELL, None, [CELL.T_cell_board])
    assert [queries.first_touch(low, tool, 0) is None for tool in (0, 1)] == [False, False]
    report = track(two_tools(), replace(CELL, tool_change=low), None, terms=TERMS)
    (found,) = (finding for finding in report.findings if finding.severity == "error")
    assert found.rule.id == "transfer-blocked"
    assert "at tool_change_deg_mm of cell two-tcps, where" in found.message
    assert "forearm collides with shoulder while cone is carried" in found.message
    assert found.message.endswith("State other joints under tool_change_deg_mm, or leave that key out: home is clear.")
    assert report.remedy is None


def test_a_place_that_no_tool_is_changed_at_may_be_blocked() -> None:
    low = CELL.home + np.array([0.0, 0.0, 1.2, 0.0, 0.0, 0.0])
    assert track(line_program(), replace(CELL, tool_change=low), None, terms=TERMS).possible


def test_no_line_is_driven_in_no_time() -> None:
    lines = motion_of(tracked()).lines
    assert min(line.duration_s for line in lines) > 2e-4
    assert max(line.length_mm / line.duration_s for line in lines) < 1000


@pytest.mark.parametrize("name", list(ARM_LANGUAGES))
def test_every_language_says_a_change_of_tools_as_planned(name: str) -> None:
    dialect = DIALECTS[name]
    report = tracked()
    joints = tracking_of(report) if dialect.needs_joints else None
    motion = make_motion(report.program, installed(), joints)
    files = dialect.render(lower(motion, dialect.capability), installed())
    assert compare(dialect.read(files), motion, installed()) == ()


def test_the_file_says_the_same_change() -> None:
    report = tracked()
    read = native.parse(native.render(report.program))
    again = replace(report, program=read)
    targets = [
        [step.target.position for step in motion_of(each).steps if isinstance(step, Reach)] for each in (report, again)
    ]
    np.testing.assert_allclose(targets[0], targets[1], atol=1e-3)


def after_a_line(*items: Instruction) -> TimedProgram:
    """A line with the first tool, then something else; times count from the line's end, poses are below the last."""
    program = line_program()
    end_s = program.totals.duration_s
    top = moves_of(program)[-1]
    later = [replace(item, time_s=item.time_s + end_s) for item in items]
    x, y, _ = top.position
    down = replace(top, time_s=later[-1].time_s + 2.0, position=(x, y, HEIGHT))
    return program_of(*program.instructions, *later, down, liquid=(("clean", 1.0),))


@pytest.mark.slow
@pytest.mark.parametrize("after_s", [0.0, 0.5])
def test_a_wait_after_the_change_begins_when_the_tool_is_there(after_s: float) -> None:
    change = Command(0.0, "NOZZLE", ("knife", "TOOL", "2"), "sequence[1]")
    requested = after_a_line(change, Wait(after_s, 1.0, "sequence[1]"))
    program = track(requested, CELL, None, terms=TERMS).program
    native.parse(native.render(program))  # refuses a wait that is cut short
    wait = next(item for item in program.instructions if isinstance(item, Wait) and str(item.made_by) == "sequence[1]")
    held = playback(program, np.linspace(wait.time_s + 1e-3, wait.time_s + wait.duration_s - 1e-3, 5)).tcp
    assert np.ptp(held, axis=0).max() < 1e-3
    begin_s = line_program().totals.duration_s + after_s
    np.testing.assert_allclose(held[0], playback(requested, np.array([begin_s + 0.5])).tcp[0], atol=1e-3)


@pytest.mark.slow
def test_a_tool_that_is_changed_some_time_after_the_last_move_is_changed_before_the_next() -> None:
    program = line_program()
    top = moves_of(program)[-1]
    end_s = program.totals.duration_s
    change = Command(end_s + 0.5, "NOZZLE", ("knife", "TOOL", "2"), "sequence[1]")
    held = replace(top, time_s=end_s + 1.0)
    report = track(program_of(*program.instructions, change, held, liquid=(("clean", 1.0),)), CELL, None, terms=TERMS)
    for move, tool, q in zip(moves_of(report.program), tools_of(report.program), report.joints.tolist(), strict=True):
        assert distance(seen(tuple(q), tool), Pose(move.position, move.quaternion)) < 1e-3


@pytest.mark.slow
def test_ways_from_home_are_checked_with_the_tool_and_the_board_where_it_lies() -> None:
    report, home = tracked(), installed().home
    check = tracking_of(report).is_clear
    assert check is not None
    rows = (home, motion_of(report).lines[0].joints)
    assert check(rows, 1, "")
    flange = CELL.T_cell_base @ flange_poses(CELL.robot, CELL.home[None])[0]
    in_the_way = replace(report, board=load_board(Path("tiny")), placements={"flip": flange})
    blocked = tracking_of(in_the_way).is_clear
    assert blocked is not None
    assert blocked(rows, 1, "")
    assert not blocked(rows, 1, "flip")

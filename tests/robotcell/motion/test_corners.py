"""A robot keeps to the lines of a program: its tool turns evenly along each, and few moves state it."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from brief_recipe import BRIEF
from tracked import moves_of

from boards.load import load_board
from geometry.frames import rotation_angles, slerp
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line, MotionProgram, Reach
from reports.files.robot_programs import tracking_of
from robotcell.cell.installation import installation_of
from robotcell.cell.load import hold_board, read_cell
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.pipeline import run

CELLS = ["ur5e-bench", "kr6-bench", "irb1200-bench", "gantry"]

pytestmark = pytest.mark.slow


@cache
def tracked(cell: str) -> tuple[CellReport, MotionProgram, MotionProgram]:
    """What the robot does, its motion, and that of the plan."""
    board = load_board(Path("tiny"))
    loaded = hold_board(read_cell(cell), board)
    program = run(BRIEF, board).program
    report = track(program, loaded.cell, board, terms=terms_of(loaded))
    installation = installation_of(loaded)
    return report, make_motion(report.program, installation, tracking_of(report)), make_motion(program, installation)


@pytest.mark.parametrize("cell", CELLS)
def test_a_robot_needs_hardly_more_lines_than_the_plan(cell: str) -> None:
    _, motion, planned = tracked(cell)
    most = 1.0 if cell == "gantry" else 1.35  # its transfers are one line each
    assert len(motion.lines) <= most * len(planned.lines)
    assert len(motion.lines) < 0.1 * len(moves_of(tracked(cell)[0].program))


@pytest.mark.parametrize("cell", CELLS)
def test_lines_have_the_speeds_of_the_plan(cell: str) -> None:
    """The controller makes its own ramps: where joints cannot follow is no reason for a slower line."""
    _, motion, planned = tracked(cell)
    fastest = [max(line.speed_mm_s for line in each.lines if line.events) for each in (motion, planned)]
    assert fastest[0] == pytest.approx(fastest[1], rel=0.02)


@pytest.mark.parametrize("cell", CELLS)
def test_between_corners_the_tool_moves_and_turns_evenly(cell: str) -> None:
    report, *_ = tracked(cell)
    moves = moves_of(report.program)
    tcp, turn = np.array([each.position for each in moves]), np.array([each.quaternion for each in moves])
    corner = np.flatnonzero(report.corner | np.isnan(report.clock))
    straight = 0
    for first, last in zip(corner[:-1].tolist(), corner[1:].tolist(), strict=True):
        way = float(np.linalg.norm(tcp[last] - tcp[first]))
        if last - first < 2 or way < 1.0:
            continue
        share = np.linalg.norm(tcp[first : last + 1] - tcp[first], axis=1) / way
        if np.isfinite(report.share[last]):
            turning = report.joints[first : last + 1, 3:]
            even = turning[0] + share[:, None] * (turning[-1] - turning[0])
            np.testing.assert_allclose(turning, even, rtol=0.0, atol=1e-4)
            straight += 1
            continue
        ends = [np.repeat(turn[at : at + 1], len(share), axis=0) for at in (first, last)]
        if float(rotation_angles(ends[0], ends[1])[0]) > np.radians(170.0):
            continue
        off = rotation_angles(slerp(ends[0], ends[1], share), turn[first : last + 1])
        assert np.degrees(off.max()) < 0.05
        straight += 1
    assert straight > 20


@pytest.mark.parametrize("cell", CELLS)
def test_another_configuration_is_a_joint_move(cell: str) -> None:
    report, motion, _ = tracked(cell)
    reaches = [step for step in motion.steps if isinstance(step, Reach)]
    inside = int(np.isnan(report.clock).sum())
    assert len(reaches) > 1
    assert sum(len(step.way) for step in reaches) >= inside
    at = np.array([line.joints for line in motion.lines if isinstance(line, Line)])
    assert np.isfinite(at).all()

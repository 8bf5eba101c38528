"""Motions in tool points: joint moves, speeds."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from installations import RING
from robot_steps import program

from programs.motion.steps import Line, Reach, SampledLine, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.writing.tool_points import MOVE, in_tool_points
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell

GANTRY = replace(installation_of(read_cell("gantry")), valves={"ring60": RING})
POSE = Pose((0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))


@pytest.mark.slow
def test_a_joint_move_is_divided_where_its_tool_point_leaves_a_straight_way() -> None:
    machine = GANTRY.tool_point
    assert machine is not None
    begin = (0.0, 0.0, 0.0, 0.0, math.radians(30))
    end = (50.0, 0.0, 0.0, math.radians(180), math.radians(30))
    motion = program(
        UseBoard("", GANTRY.T_base_board, ""), UseTool(1, "ring60", ""), Reach(POSE, begin, ""), Reach(POSE, end, "")
    )
    moves = [step.joints for step in in_tool_points(motion, GANTRY).steps if isinstance(step, Reach)]
    assert moves[-1] == pytest.approx(machine.axes(np.array([end]))[0])
    own = np.array(moves[-(len(moves) - 1) :])
    shares = np.linspace(0.0, 1.0, 301)[:, None]
    planned = machine.axes(np.array(begin) + shares * (np.array(end) - np.array(begin)))
    drawn = np.concatenate([a + np.linspace(0, 1, 400)[:, None] * (b - a) for a, b in pairwise(own)])
    apart = np.linalg.norm(planned[:, None, :3] - drawn[None, :, :3], axis=2).min(axis=1)
    late = shares[:, 0] > 0.4
    assert apart[late].max() <= 1.1 * math.sqrt(3.0) * MOVE[0]
    assert len(moves) < 40


def test_a_line_keeps_to_the_speed_that_the_robot_reaches() -> None:
    samples = SampledLine(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 1.0]), np.zeros((3, 5)))
    line = Line(POSE, Pose((40.0, 0.0, 0.0), POSE.quaternion), 100.0, 0.0, 0.0, samples, 0.0, "s")
    (done,) = (step for step in in_tool_points(program(line), GANTRY).steps if isinstance(step, Line))
    assert done.speed_mm_s == pytest.approx(20.0)


def test_the_angle_between_two_jets_is_that_of_their_directions() -> None:
    machine = GANTRY.tool_point
    assert machine is not None
    angle = {}
    for c_deg, b_deg in ((0.0, 0.0), (90.0, 0.0), (0.0, 20.0), (180.0, 20.0)):
        row = np.zeros(5)
        row[machine.swing], row[7 - machine.swing] = math.radians(c_deg), math.radians(b_deg)
        angle[c_deg, b_deg] = row
    assert machine.jet_angle(angle[0.0, 0.0], angle[90.0, 0.0]) == pytest.approx(0.0, abs=1e-7)
    assert math.degrees(machine.jet_angle(angle[0.0, 20.0], angle[180.0, 20.0])) == pytest.approx(40.0)
    assert math.degrees(machine.jet_angle(angle[0.0, 20.0], angle[90.0, 0.0])) == pytest.approx(20.0)

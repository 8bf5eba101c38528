import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from installations import RING, small_cell
from robot_steps import program

from programs.motion.installation import Joint
from programs.motion.samples import SampledLine
from programs.motion.steps import Line, Reach, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.writing.axes import (
    MOVE,
    allowed_of,
    in_degrees_and_mm,
    in_tool_points,
    needed_samples,
    place_on,
    units_of,
)
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell

CELL = replace(small_cell(), joints=(Joint("X", "prismatic"), Joint("C", "revolute")))
UNITS = units_of(CELL)


def arc(radius_mm: float, turn_rad: float, samples: int = 301) -> SampledLine:
    """X follows what a lever does while C turns."""
    shares = np.linspace(0.0, 1.0, samples)
    joints = np.column_stack((radius_mm * np.cos(turn_rad * shares), turn_rad * shares))
    return SampledLine(shares * 2.0, shares, joints)


def test_degrees_and_mm() -> None:
    assert in_degrees_and_mm((12.5, math.pi / 2), CELL) == pytest.approx((12.5, 90.0))
    assert in_degrees_and_mm((math.pi,), replace(CELL, joints=())) == pytest.approx((180.0,))


def test_a_straight_run_needs_its_end_only() -> None:
    shares = np.linspace(0.0, 1.0, 50)
    samples = SampledLine(shares, shares, np.column_stack((80.0 * shares, 0.3 * shares)))
    assert needed_samples(samples, UNITS, 0.7) == (49,)


@settings(max_examples=40)
@given(st.floats(1.0, 400.0), st.floats(-3.0, 3.0))
def test_between_the_samples_kept_the_axes_stay_within_what_is_allowed(radius: float, turn: float) -> None:
    samples = arc(radius, turn)
    kept = [0, *needed_samples(samples, UNITS, 1.0)]
    assert kept[-1] == len(samples.shares) - 1
    straight = np.column_stack(
        [np.interp(samples.shares, samples.shares[kept], column[kept]) for column in samples.joints.T]
    )
    off = np.abs(straight - samples.joints) / UNITS / allowed_of(UNITS)
    assert off.max() <= 1.0 + 1e-9
    for at in range(len(kept) - 1):
        middle = 0.5 * (samples.joints[kept[at]] + samples.joints[kept[at + 1]]) / UNITS
        assert place_on(samples, UNITS, tuple(middle.tolist()), 0.0)[1] <= 1.0 + 1e-6


@given(st.floats(0.05, 0.95))
def test_axes_on_the_motion_are_found_where_they_are(share: float) -> None:
    samples = arc(200.0, 1.0, 2001)
    axes = np.array([np.interp(share, samples.shares, column) for column in samples.joints.T]) / UNITS
    found, off = place_on(samples, UNITS, tuple(axes.tolist()), 0.0)
    assert found == pytest.approx(share, abs=1e-6)
    assert off < 1e-6


def test_what_lies_behind_is_not_looked_at() -> None:
    """There and back: the same axes twice."""
    shares = np.linspace(0.0, 1.0, 201)
    there = np.minimum(shares, 1.0 - shares)
    samples = SampledLine(shares, shares, np.column_stack((100.0 * there, 0.0 * there)))
    assert place_on(samples, UNITS, (20.0, 0.0), 0.0)[0] == pytest.approx(0.2)
    assert place_on(samples, UNITS, (20.0, 0.0), 0.5)[0] == pytest.approx(0.8)


def test_axes_off_the_motion_are_off_in_units_of_what_is_allowed() -> None:
    samples = arc(200.0, 1.0)
    assert place_on(samples, UNITS, (200.0, -0.5), 0.0)[1] > 200
    assert place_on(samples, UNITS, (200.0,), 0.0)[1] == math.inf


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

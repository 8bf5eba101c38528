import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shown_cell import shown_cell, sway
from tiny_session import tiny_session

from programs.program import MoveTo, Wait
from webui.layers.robot.joint_plots import curves_html, envelope, joint_curves, key_times, plot_cursor_html, use_of
from webui.layers.robot.robot import joint_motion


def motion_of(times, joints, waits=()):
    moves = [MoveTo(time_s, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.0, "") for time_s in times]
    items = [*moves, *(Wait(begin, lasting, "") for begin, lasting in waits)]
    program = SimpleNamespace(instructions=sorted(items, key=lambda item: item.time_s))
    return joint_motion(program, np.array(joints, dtype=float).reshape(len(times), -1))


def test_speed_and_acceleration_of_a_known_motion():
    times = np.linspace(0.0, 2.0, 401)
    robot = replace(shown_cell().robot, joints=shown_cell().robot.joints[:1])
    motion = motion_of(times, np.radians(10.0) * np.sin(3.0 * times))
    position, speed, acceleration = (
        joint_curves(robot, motion, each)[0] for each in ("position", "speed", "acceleration")
    )
    np.testing.assert_allclose(position.values, 10.0 * np.sin(3.0 * times), atol=1e-9)
    np.testing.assert_allclose(speed.values, 30.0 * np.cos(3.0 * speed.times), atol=0.01)
    np.testing.assert_allclose(acceleration.values, -90.0 * np.sin(3.0 * acceleration.times), atol=0.7)
    assert position.unit == "\N{DEGREE SIGN}"
    assert speed.highest == pytest.approx(np.degrees(robot.joints[0].speed))


def test_an_even_acceleration_is_seen_as_it_is_however_samples_are_spaced():
    times = np.array([0.0, 0.058, 0.1, 0.126, 0.146, 0.2, 0.21])
    robot = replace(shown_cell().robot, joints=shown_cell().robot.joints[:1])
    curve = joint_curves(robot, motion_of(times, 0.5 * np.radians(200.0) * times**2), "acceleration")[0]
    np.testing.assert_allclose(curve.values, 200.0, rtol=1e-6)


def test_a_joint_stands_while_the_program_waits():
    robot = replace(shown_cell().robot, joints=shown_cell().robot.joints[:1])
    motion = motion_of([0.0, 1.0, 4.0], [0.0, 1.0, 2.0], [(1.0, 2.0)])
    assert key_times(motion) == pytest.approx([0.0, 1.0, 3.0, 4.0])
    speed = joint_curves(robot, motion, "speed")[0]
    assert speed.values == pytest.approx(np.degrees([1.0, 0.0, 1.0]))


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), samples=st.integers(2, 300), columns=st.integers(1, 60))
def test_an_envelope_leaves_no_extreme_out_and_adds_none(seed, samples, columns):
    random = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.sort(random.uniform(0.0, 7.0, samples - 2)), [7.0]])
    values = random.normal(size=samples)
    low, high = envelope(times, values, 7.0, columns)
    assert low.shape == high.shape == (columns,)
    assert (low <= high).all()
    assert low.min() == pytest.approx(values.min())
    assert high.max() == pytest.approx(values.max())
    assert (high[:-1] >= low[1:] - 1e-9).all()  # neighbours touch: what is drawn has no gap
    assert (low[:-1] <= high[1:] + 1e-9).all()


def test_what_breaks_a_limit_is_said_and_a_joint_without_limit_too():
    robot = shown_cell().robot
    first = replace(robot.joints[0], speed=np.radians(20.0))
    free = replace(robot.joints[1], speed=np.inf, name="<b>")
    pair = replace(robot, joints=(first, free))
    motion = motion_of([0.0, 1.0], np.radians([[0.0, 0.0], [30.0, 30.0]]))
    curves = joint_curves(pair, motion, "speed")
    assert [use_of(curve) for curve in curves] == pytest.approx([1.5, 0.0])
    html = curves_html(curves, 1.0)
    assert "30 of 20\N{DEGREE SIGN}/s (150%)" in html
    assert "no limit" in html
    assert "<b>" not in html


def test_a_real_program_is_drawn_with_few_points_and_every_joint():
    cell, program = shown_cell(), tiny_session().run.program
    motion = joint_motion(program, sway(cell, program))
    for quantity in ("position", "speed", "acceleration"):
        curves = joint_curves(cell.robot, motion, quantity)
        html = curves_html(curves, program.totals.duration_s)
        assert [curve.name for curve in curves] == [joint.name for joint in cell.robot.joints]
        assert html.count("<polygon") == cell.robot.dof
        assert "nan" not in html
        assert "inf" not in html
        assert len(html) < 100_000


def test_the_cursor_spans_all_curves_and_stays_inside():
    at = [float(re.search(r"left:([\d.]+)%", plot_cursor_html(now_s, 8.0, 6))[1]) for now_s in (-1.0, 4.0, 99.0)]
    assert at == [0.0, 50.0, 100.0]

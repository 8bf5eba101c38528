from dataclasses import replace

import numpy as np
import pytest
from shown_cell import shown_cell, sway
from tiny_session import tiny_session

from programs.playback import playback
from robotcell.robot.robot import jacobians, limit_share
from webui.layers.robot.robot import joint_motion
from webui.scene.reach_colours import METRICS, measure, reach_glb, reached_path


def swaying():
    cell, program = shown_cell(), tiny_session().run.program
    return cell, program, joint_motion(program, sway(cell, program))


def test_pieces_are_what_is_sprayed_and_leave_no_corner_out():
    _, program, motion = swaying()
    reached = reached_path(program)
    lengths = np.linalg.norm(np.diff(reached.segments, axis=1)[:, 0], axis=1)
    times = np.linspace(0.0, program.totals.duration_s, 40_001)
    states = playback(program, times)
    steps = np.linalg.norm(np.diff(states.tcp, axis=0), axis=1)
    sprayed_mm = steps[states.spraying[1:] & states.spraying[:-1]].sum()
    assert lengths.sum() == pytest.approx(sprayed_mm, rel=0.01)
    places = states.tcp[states.spraying]
    middles = reached.segments.mean(axis=1)
    away = [np.linalg.norm(places - middle, axis=1).min() for middle in middles[:: max(1, len(middles) // 50)]]
    assert max(away) < 0.3
    assert (np.diff(motion.times[reached.move]) >= 0).all()


def test_measures_are_those_of_the_branch_at_that_move():
    cell, program, motion = swaying()
    reached = reached_path(program)
    row = int(reached.move[len(reached.move) // 2])
    values = measure("manipulability", cell, motion, reached.move)
    wanted = abs(np.linalg.det(jacobians(cell.robot, motion.joints[row : row + 1])[0]))
    assert values[len(values) // 2] == pytest.approx(wanted)
    condition = measure("inverse condition", cell, motion, reached.move)
    assert ((condition > 0) & (condition <= 1)).all()


def test_a_joint_at_its_limit_counts_nothing_and_free_ones_do_not_count():
    robot = shown_cell().robot
    pair = replace(
        robot,
        joints=(
            replace(robot.joints[0], lowest=-1.0, highest=3.0),
            replace(robot.joints[1], lowest=-np.inf, highest=np.inf),
        ),
    )
    shares = limit_share(pair, np.array([[1.0, 9.0], [3.0, 0.0], [-1.0, 0.0], [2.0, 0.0]]))
    assert shares == pytest.approx([1.0, 0.0, 0.0, 0.5])


def test_colours_go_from_the_least_to_the_most():
    cell, program, motion = swaying()
    reached = reached_path(program)
    for metric in set(METRICS.values()) - {"clearance"}:
        values = measure(metric, cell, motion, reached.move)
        glb, legend = reach_glb(reached, values, (float(values.min()), float(values.max())), 0.5)
        assert len(glb) > 1000
        assert next(iter(legend)) == f"{values.min():.3g}"
        assert list(legend)[-1] == f"{values.max():.3g}"


def test_a_program_that_sprays_nothing_has_nothing_to_colour():
    _, program, _ = swaying()
    dry = replace(
        program, instructions=tuple(item for item in program.instructions if type(item).__name__ != "SetNozzle")
    )
    reached = reached_path(dry)
    assert reached.segments.shape == (0, 2, 3)
    assert reach_glb(reached, np.empty(0), (0.0, 1.0), 0.5)[0] == b""

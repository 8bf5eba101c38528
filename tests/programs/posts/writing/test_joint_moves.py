"""Joint motions take their planned times, in every language, and are slow where nothing is planned."""

from dataclasses import replace

import numpy as np
import pytest
from installations import small_cell
from joint_journey import CONTROLLER, FAR, HOME, NEAR, begun, cell_of, journey, reach

from programs.export import write_motion
from programs.motion.steps import Call, EndRepeat, Reach, Repeat, Step
from programs.posts.dialects import DIALECTS
from programs.posts.rebuilt import ReadReach
from programs.posts.writing.joint_moves import CAUTIOUS, machine_of, pace_moves
from specs.source import NO_SOURCE

LANGUAGES = [name for name, each in DIALECTS.items() if each.maker is not None]


def paces(*steps: Step) -> list[int]:
    found = pace_moves(steps, cell_of(), CONTROLLER)
    return [found.get(id(step), CAUTIOUS).percent for step in steps if isinstance(step, Reach)]


def test_a_joint_motion_is_as_slow_as_its_planned_time_allows() -> None:
    machine = machine_of(cell_of(), CONTROLLER)
    for seconds in (0.8, 1.3, 4.0):
        percent = paces(begun(), reach(HOME, FAR, seconds))[1]
        assert machine.joint_time(np.degrees(FAR), 0.01 * percent) <= seconds
        assert machine.joint_time(np.degrees(FAR), 0.01 * (percent - 1)) > seconds


def test_one_that_no_speed_can_do_in_time_goes_at_full_speed() -> None:
    assert paces(begun(), reach(HOME, FAR, 0.1)) == [10, 100]


def test_one_that_may_begin_elsewhere_is_slow() -> None:
    out, back = reach(HOME, FAR, 1.3), reach(FAR, HOME, 1.3)
    assert paces(out, back)[0] == 10  # nothing states where the robot is
    assert paces(begun(), out, Call("flip", NO_SOURCE), back)[2] == 10
    assert paces(begun(), reach(NEAR, FAR, 1.3))[1] == 10
    loop, end = Repeat(2, "resistivity", 1.0, None, NO_SOURCE), EndRepeat(NO_SOURCE)
    assert paces(begun(), loop, out, end)[1] == 10  # in its second turn it begins where it ends
    assert min(paces(begun(), loop, out, back, end)[1:]) > 10


def test_joints_of_unknown_speed_are_slow() -> None:
    steps = (begun(), reach(HOME, FAR, 1.3))
    assert pace_moves(steps, small_cell(), CONTROLLER) == {}


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_text_takes_the_planned_time_of_joint_motions(language: str) -> None:
    motion, cell = journey(language)
    done = write_motion(DIALECTS[language], motion, cell)
    assert done.forecast is not None
    controller = DIALECTS[language].controller
    assert controller is not None
    for move in done.forecast.moves:
        took = move.predicted_s - controller.settle_s - controller.rise_s
        assert 0.93 * move.planned_s <= took <= move.planned_s + 1e-3
    assert len(done.forecast.moves) == 3


@pytest.mark.parametrize("language", LANGUAGES)
def test_another_speed_of_a_joint_motion_is_read_as_another(language: str) -> None:
    motion, cell = journey(language)
    slower = tuple(
        replace(step, way=(replace(step.way[0], seconds=2 * step.duration_s),)) if isinstance(step, Reach) and step.way
        else step for step in motion.steps
    )  # fmt: skip
    read = [write_motion(DIALECTS[language], each, cell).rebuilt for each in (motion, replace(motion, steps=slower))]
    terms = [[(s.speed_share, s.duration_s) for s in each.steps if isinstance(s, ReadReach)] for each in read]
    assert all(one != other for one, other in zip(terms[0][1:], terms[1][1:], strict=True))

"""Where a motion has to be reached anew, and whose jet it is."""

from collections.abc import Sequence

import pytest
from installations import small_cell
from small_programs import DOWN, program_of

from programs.motion.installation import Channel
from programs.motion.make_motion import make_motion
from programs.motion.steps import Call, Line, Reach, Step, Switch, UseTool
from programs.program import Command, MoveTo, SetNozzle, TimedProgram

UP, DOWN_THERE = (0.0, 0.0, 110.0), (0.0, 0.0, 50.0)


def called(next_place: tuple[float, float, float]) -> TimedProgram:
    """A routine that the cell knows nothing of, then a move that takes no time, and a line."""
    return program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "s"),
        MoveTo(0.0, UP, DOWN, 0.0, "s"),
        Command(0.0, "CALL", ("turn_table",), "s"),
        MoveTo(0.0, next_place, DOWN, 0.0, "s"),
        MoveTo(1.0, (40.0, 0.0, 50.0), DOWN, 40.0, "s"),
    )


def test_where_a_routine_leaves_the_orifice_elsewhere_the_robot_goes_before_it_drives_a_line() -> None:
    steps = [
        step for step in make_motion(called(DOWN_THERE), small_cell()).steps if isinstance(step, Reach | Call | Line)
    ]
    assert [type(step) for step in steps] == [Reach, Call, Reach, Line]
    reach, line = steps[2:]
    assert isinstance(reach, Reach)
    assert isinstance(line, Line)
    assert reach.target == line.start
    assert reach.target.position == DOWN_THERE


def test_where_a_routine_leaves_it_where_it_is_nothing_is_reached_again() -> None:
    steps = make_motion(called(UP), small_cell()).steps
    assert sum(isinstance(step, Reach) for step in steps) == 1


def test_a_jet_that_goes_on_with_another_nozzle_is_shut_at_the_first() -> None:
    program = program_of(
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "s"),
        MoveTo(0.0, UP, DOWN, 0.0, "s"),
        SetNozzle(0.0, True, "s"),
        MoveTo(1.0, DOWN_THERE, DOWN, 0.0, "s"),
        Command(1.0, "NOZZLE", ("knife", "TOOL", "2"), "s"),
        MoveTo(2.0, UP, DOWN, 0.0, "s"),
        SetNozzle(2.0, False, "s"),
    )
    steps = make_motion(program, small_cell()).steps
    change = next(at for at, step in enumerate(steps) if isinstance(step, UseTool) and step.number == 2)
    valves = small_cell().valves
    wash, air = (valves[name].channel for name in ("ring60", "knife"))
    assert switched(steps[:change])[2:] == [(wash, 1.0), (wash, 0.0)]
    assert switched(steps[change:]) == [(air, 1.0), (air, 0.0)]


@pytest.mark.parametrize("at_s", [0.2, 0.5, 3.0, 4.0])
def test_a_line_switches_the_jet_as_far_along_as_the_program_does(at_s: float) -> None:
    moves = (
        Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "s"),
        MoveTo(0.0, UP, DOWN, 0.0, "s"),
        SetNozzle(at_s, True, "s"),
        MoveTo(4.0, DOWN_THERE, DOWN, 15.0, "s"),
        SetNozzle(8.0, False, "s"),
        MoveTo(8.0, UP, DOWN, 15.0, "s"),
    )
    program = program_of(*sorted(moves, key=lambda each: each.time_s))
    lines = [step for step in make_motion(program, small_cell()).steps if isinstance(step, Line)]
    (opened,), (shut,) = (line.events for line in lines)
    assert (opened.value, opened.share) == (1.0, pytest.approx(at_s / 4.0))
    assert opened.signal_s == pytest.approx(at_s - 0.04)  # the nozzle's lag
    assert (shut.value, shut.share) == (0.0, 1.0)


def switched(steps: Sequence[Step]) -> list[tuple[Channel, float]]:
    """What changes, in order: at rest and on lines."""
    changes: list[tuple[Channel, float]] = []
    for step in steps:
        if isinstance(step, Switch):
            changes.append((step.channel, step.value))
        elif isinstance(step, Line):
            changes += [(event.channel, event.value) for event in step.events]
    return changes

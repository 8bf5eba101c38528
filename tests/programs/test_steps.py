"""Where a motion has to be reached anew."""

from installations import small_cell
from small_programs import DOWN, program_of

from programs.motion import Call, Line, Reach
from programs.program import Command, MoveTo, TimedProgram
from programs.steps import make_motion

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

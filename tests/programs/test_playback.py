import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_programs import DOWN, hand_program, program_of, programs

from programs.errors import ProgramError
from programs.playback import ToolStates, build_timeline, play, playback
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait


def states_at(program: TimedProgram, *times: float) -> ToolStates:
    return playback(program, np.array(times))


def line_with_a_wait() -> TimedProgram:
    """10 mm/s along x for 1 s, 0.5 s of rest, then 20 mm/s along y for 1 s."""
    return program_of(
        MoveTo(0.0, (0.0, 0.0, 50.0), DOWN, 0.0, "start"),
        SetNozzle(0.25, True, "a"),
        MoveTo(1.0, (10.0, 0.0, 50.0), DOWN, 10.0, "a"),
        Wait(1.0, 0.5, "pause"),
        MoveTo(2.5, (10.0, 20.0, 50.0), DOWN, 20.0, "b"),
        SetNozzle(2.5, False, "b"),
    )


def test_between_two_moves_it_goes_straight_at_constant_speed() -> None:
    states = states_at(line_with_a_wait(), 0.0, 0.3, 0.9, 2.0)
    np.testing.assert_allclose(states.tcp[:, :2], [[0, 0], [3, 0], [9, 0], [10, 10]], atol=1e-12)
    np.testing.assert_allclose(states.speed, [10, 10, 10, 20])


def test_a_wait_holds_the_pose_and_the_next_move_takes_the_rest_of_the_time() -> None:
    states = states_at(line_with_a_wait(), 1.0, 1.2, 1.4999, 1.5, 1.75)
    np.testing.assert_allclose(states.tcp[:, :2], [[10, 0], [10, 0], [10, 0], [10, 0], [10, 5]], atol=1e-9)
    np.testing.assert_allclose(states.speed, [0, 0, 0, 20, 20])
    assert [states.makers[maker] for maker in states.made_by] == ["pause", "pause", "pause", "b", "b"]


def test_a_wait_between_two_moves_interrupts_the_segment() -> None:
    program = program_of(
        MoveTo(0.0, (0.0, 0.0, 50.0), DOWN, 0.0, ""),
        Wait(1.0, 2.0, ""),
        MoveTo(4.0, (20.0, 0.0, 50.0), DOWN, 10.0, ""),
    )
    np.testing.assert_allclose(states_at(program, 0.5, 1.0, 2.0, 3.0, 3.5).tcp[:, 0], [5, 10, 10, 10, 15], atol=1e-12)


def test_it_stands_still_before_the_first_and_after_the_last() -> None:
    states = states_at(line_with_a_wait(), -math.inf, -1.0, 2.5, 99.0, math.inf)
    np.testing.assert_array_equal(states.tcp[:, 1], [0, 0, 20, 20, 20])
    np.testing.assert_array_equal(states.speed[[0, 1, 2, 3, 4]], [0, 0, 0, 0, 0])
    assert states.spraying.tolist() == [False] * 5
    assert states.instruction.tolist() == [0, 0, 5, 5, 5]


def test_the_jet_is_on_from_on_until_off() -> None:
    states = states_at(line_with_a_wait(), 0.0, 0.2499, 0.25, 1.2, 2.4999, 2.5)
    assert states.spraying.tolist() == [False, False, True, True, True, False]


def test_the_last_of_several_switches_at_one_moment_counts() -> None:
    park = MoveTo(0.0, (0.0, 0.0, 50.0), DOWN, 0.0, "")
    flicker = program_of(park, SetNozzle(1.0, True, ""), SetNozzle(1.0, False, ""))
    assert states_at(flicker, 0.9, 1.0, 1.1).spraying.tolist() == [False, False, False]


def test_the_nozzle_turns_at_a_constant_rate_the_short_way_round() -> None:
    half = math.radians(40) / 2
    tilted = (-math.sin(half), -math.cos(half), 0.0, 0.0)  # the same sense as DOWN only after its sign is turned
    program = program_of(MoveTo(0.0, (0.0, 0.0, 50.0), DOWN, 0.0, ""), MoveTo(2.0, (0.0, 0.0, 50.0), tilted, 0.0, ""))
    states = states_at(program, 0.0, 0.5, 1.0, 2.0)
    tilt = np.degrees(np.arccos(-states.approach[:, 2]))
    np.testing.assert_allclose(tilt, [0, 10, 20, 40], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(states.approach, axis=1), 1.0)
    np.testing.assert_allclose(states.approach[:, 0], 0, atol=1e-12)


def test_the_jet_points_along_tool_z() -> None:
    quarter = math.sqrt(0.5)
    cases = {(1.0, 0.0, 0.0, 0.0): (0, 0, 1), (quarter, 0.0, quarter, 0.0): (1, 0, 0), DOWN: (0, 0, -1)}
    for quaternion, direction in cases.items():
        states = states_at(program_of(MoveTo(0.0, (0.0, 0.0, 0.0), quaternion, 0.0, "")), 0.0)
        np.testing.assert_allclose(states.approach[0], direction, atol=1e-12)


def test_function_nozzle_and_solution_hold_until_the_next_command() -> None:
    program = program_of(
        MoveTo(0.0, (0.0, 0.0, 50.0), DOWN, 0.0, ""),
        Command(1.0, "FUNCTION", ("clean",), ""),
        Command(1.0, "NOZZLE", ("ring60", "TOOL", "1"), ""),
        Command(1.0, "SOLUTION", ("soap",), ""),
        Command(2.0, "FUNCTION", ("rinse",), ""),
        Command(3.0, "FUNCTION", ("clean",), ""),
    )
    states = states_at(program, 0.5, 1.0, 2.5, 3.5)
    assert [states.functions[code] for code in states.function] == ["", "clean", "rinse", "clean"]
    assert [states.nozzles[code] for code in states.nozzle] == ["", "ring60", "ring60", "ring60"]
    assert [states.solutions[code] for code in states.solution] == ["", "soap", "soap", "soap"]


def test_the_move_under_way_is_the_one_it_goes_to() -> None:
    program = hand_program()
    states = states_at(program, 0.5, 1.5, 2.1, 3.0, 4.0)
    kinds = [type(program.instructions[index]) for index in states.instruction]
    assert kinds == [MoveTo, MoveTo, Wait, MoveTo, MoveTo]
    assert [states.makers[maker] for maker in states.made_by] == [
        str(program.instructions[index].made_by) for index in states.instruction
    ]


def test_a_program_without_a_move_cannot_be_played() -> None:
    with pytest.raises(ProgramError, match="no MOVE"):
        build_timeline(program_of(SetNozzle(0.0, False, "")))


@pytest.mark.slow
@settings(max_examples=30)
@given(program=programs(), times=st.lists(st.floats(-5, 60), min_size=1, max_size=20))
def test_the_order_of_the_questions_changes_no_answer(program: TimedProgram, times: list[float]) -> None:
    timeline = build_timeline(program)
    together = play(timeline, np.array(times))
    for row, time_s in enumerate(times):
        alone = play(timeline, np.array([time_s]))
        np.testing.assert_array_equal(alone.tcp[0], together.tcp[row])
        np.testing.assert_array_equal(alone.quaternion[0], together.quaternion[row])
        assert alone.spraying[0] == together.spraying[row]
        assert alone.instruction[0] == together.instruction[row]


@settings(max_examples=30)
@given(program=programs())
def test_every_move_is_reached_at_its_time(program: TimedProgram) -> None:
    moves = [item for item in program.instructions if isinstance(item, MoveTo)]
    last_at = {move.time_s: move for move in moves}  # of several at one moment the last counts
    waited = {item.time_s for item in program.instructions if isinstance(item, Wait)}
    states = playback(program, np.array(list(last_at)))
    for row, (time_s, move) in enumerate(last_at.items()):
        assert time_s in waited or np.abs(states.tcp[row] - move.position).max() < 1e-6


@pytest.mark.slow
@settings(max_examples=30)
@given(program=programs(), times=st.lists(st.floats(-5, 60), min_size=1, max_size=20))
def test_nothing_is_ever_not_a_number(program: TimedProgram, times: list[float]) -> None:
    states = playback(program, np.array(times))
    assert np.isfinite(states.tcp).all()
    assert np.isfinite(states.speed).all()
    np.testing.assert_allclose(np.linalg.norm(states.quaternion, axis=1), 1.0)
    np.testing.assert_allclose(np.linalg.norm(states.approach, axis=1), 1.0)


@pytest.mark.slow
@settings(max_examples=30)
@given(program=programs(), times=st.lists(st.floats(0, 60), min_size=1, max_size=20), shift=st.floats(-100, 100))
def test_a_moved_program_plays_moved(program: TimedProgram, times: list[float], shift: float) -> None:
    moved = program_of(
        *(
            MoveTo(i.time_s, (i.position[0] + shift, *i.position[1:]), i.quaternion, i.speed_mm_s, i.made_by)
            if isinstance(i, MoveTo)
            else i
            for i in program.instructions
        )
    )
    here, there = playback(program, np.array(times)), playback(moved, np.array(times))
    np.testing.assert_allclose(there.tcp - here.tcp, np.tile([shift, 0, 0], (len(times), 1)), atol=1e-9)
    np.testing.assert_array_equal(there.instruction, here.instruction)

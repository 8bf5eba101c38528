from dataclasses import replace

import numpy as np
import pytest
from robot_steps import DOWN, ORIGIN

from programs.motion.layout import lay_out, on_time
from programs.motion.tracks import Track
from programs.playback import build_timeline
from programs.program import Command, Instruction, MoveTo, TimedProgram, Totals, Wait


def move(time_s: float, x: float) -> MoveTo:
    return MoveTo(time_s, (x, 0.0, 50.0), DOWN, 10.0, "s")


def tracks_of(*instructions: Instruction) -> list[Track]:
    """The stretches of motion; the moves have joints 0, 1, 2 and so on."""
    moves = sum(isinstance(item, MoveTo) for item in instructions)
    program = TimedProgram(ORIGIN, Totals(2.0, 0.0, 20.0, moves, ()), instructions)
    layout = lay_out(program, on_time(program, np.arange(moves, dtype=np.float64)[:, None]), build_timeline(program))
    return [item for item in layout.items if isinstance(item, Track)]


def first_joints(*instructions: Instruction) -> list[list[float]]:
    """Where the joints are when each track begins."""
    return [track.joints[0].tolist() for track in tracks_of(*instructions)]


@pytest.mark.parametrize("words", [("NOZZLE", "ring60", "TOOL", "2"), ("CALL", "flip_to_bottom")])
def test_after_another_tool_the_joints_are_those_of_the_same_pose_said_again(words: tuple[str, ...]) -> None:
    at = Command(1.0, words[0], words[1:], "s")
    assert first_joints(move(0.0, 0.0), move(1.0, 10.0), at, move(1.0, 10.0), move(2.0, 20.0)) == [[0.0], [2.0]]
    assert first_joints(move(0.0, 0.0), move(1.0, 10.0), at, move(2.0, 20.0)) == [[0.0], [1.0]]


def test_after_another_tool_the_motion_begins_where_the_next_move_says_at_once() -> None:
    """The orifice of the new tool is elsewhere, and the arm stands still: nothing goes from the one to the other."""
    words = [("NOZZLE", "knife", "TOOL", "2"), ("SOLUTION", "hot-air"), ("SET", "pressure_bar", "4.000")]
    words += [("CALL", "flip_to_bottom"), ("GRIP", "close")]
    commands = [Command(1.0, word, tuple(rest), "s") for word, *rest in words]
    tracks = tracks_of(move(0.0, 0.0), move(1.0, 10.0), *commands, move(1.0, 70.0), move(2.0, 80.0))
    assert [track.tcp[:, 0].tolist() for track in tracks] == [[0.0, 10.0], [70.0, 80.0]]
    assert [track.times.tolist() for track in tracks] == [[0.0, 1.0], [1.0, 2.0]]
    assert [track.joints[:, 0].tolist() for track in tracks] == [[0.0, 1.0], [2.0, 3.0]]


def test_the_same_tool_again_moves_nothing() -> None:
    again = [Command(at, "NOZZLE", ("ring60", "TOOL", "1"), "s") for at in (0.0, 1.0)]
    tracks = tracks_of(again[0], move(0.0, 0.0), move(1.0, 10.0), again[1], move(1.0, 70.0), move(2.0, 80.0))
    assert tracks[-1].tcp[:, 0].tolist() == [10.0, 70.0, 80.0]


def test_another_tool_with_a_move_later_begins_where_the_orifice_was() -> None:
    change = Command(1.0, "NOZZLE", ("knife", "TOOL", "2"), "s")
    tracks = tracks_of(move(0.0, 0.0), move(1.0, 10.0), change, move(2.0, 80.0))
    assert tracks[-1].tcp[:, 0].tolist() == [10.0, 80.0]


@pytest.mark.parametrize("at", [Command(1.99999, "FUNCTION", ("clean",), "s"), Wait(1.99999, 0.5, "s")])
def test_what_comes_just_before_the_end_of_a_move_comes_at_its_end(at: Command | Wait) -> None:
    held = 0.5 if isinstance(at, Wait) else 0.0
    tracks = tracks_of(move(0.0, 0.0), at, move(2.0 + held, 10.0), move(3.0 + held, 20.0))
    assert [track.tcp[:, 0].tolist() for track in tracks] == [[0.0, 10.0], [10.0, 20.0]]


def test_the_sign_of_a_quaternion_says_nothing_about_the_joints() -> None:
    w, x, y, z = DOWN
    turned = replace(move(1.0, 10.0), quaternion=(-w, -x, -y, -z))
    stop = Command(1.5, "FUNCTION", ("clean",), "s")
    _, (joint,) = first_joints(move(0.0, 0.0), turned, stop, move(2.0, 20.0))
    assert joint == pytest.approx(1.5)

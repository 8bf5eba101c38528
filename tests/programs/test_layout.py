from dataclasses import replace

import numpy as np
import pytest
from robot_steps import DOWN, ORIGIN

from programs.layout import lay_out
from programs.program import Command, Instruction, MoveTo, TimedProgram, Totals
from programs.tracks import Track


def move(time_s: float, x: float) -> MoveTo:
    return MoveTo(time_s, (x, 0.0, 50.0), DOWN, 10.0, "s")


def first_joints(*instructions: Instruction) -> list[list[float]]:
    """Where the joints are when each track begins; the moves have 0, 1, 2 and so on."""
    moves = sum(isinstance(item, MoveTo) for item in instructions)
    program = TimedProgram(ORIGIN, Totals(2.0, 0.0, 20.0, moves, ()), instructions)
    layout = lay_out(program, np.arange(moves, dtype=np.float64)[:, None])
    return [item.joints[0].tolist() for item in layout.items if isinstance(item, Track)]


@pytest.mark.parametrize("words", [("NOZZLE", "ring60", "TOOL", "2"), ("CALL", "flip_to_bottom")])
def test_after_another_tool_the_joints_are_those_of_the_same_pose_said_again(words: tuple[str, ...]) -> None:
    at = Command(1.0, words[0], words[1:], "s")
    assert first_joints(move(0.0, 0.0), move(1.0, 10.0), at, move(1.0, 10.0), move(2.0, 20.0)) == [[0.0], [2.0]]
    assert first_joints(move(0.0, 0.0), move(1.0, 10.0), at, move(2.0, 20.0)) == [[0.0], [1.0]]


def test_the_sign_of_a_quaternion_says_nothing_about_the_joints() -> None:
    w, x, y, z = DOWN
    turned = replace(move(1.0, 10.0), quaternion=(-w, -x, -y, -z))
    stop = Command(1.5, "FUNCTION", ("clean",), "s")
    _, (joint,) = first_joints(move(0.0, 0.0), turned, stop, move(2.0, 20.0))
    assert joint == pytest.approx(1.5)

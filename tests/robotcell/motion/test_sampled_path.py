"""The sampled path of the TCP: where the jet is on, and when."""

import numpy as np
import pytest
from small_cells import CELL
from small_programs import DOWN, program_of
from tracked import line_program

from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from robotcell.cell.load import read_cell_text
from robotcell.motion.sampled_path import SampledPath, sample_path


def sampled(program: TimedProgram) -> SampledPath:
    return sample_path(program, read_cell_text(CELL).cell, frozenset(), {})


def switches(program: TimedProgram) -> list[tuple[float, bool]]:
    return [(item.time_s, item.spraying) for item in program.instructions if isinstance(item, SetNozzle)]


@pytest.mark.parametrize("speed", [20.0, 50.0])
def test_the_jet_is_on_from_its_switch_to_its_switch_both_included(speed: float) -> None:
    program = line_program(speed)
    (on_s, on), (off_s, off) = switches(program)
    assert on
    assert not off
    path = sampled(program)
    assert np.abs(path.times - on_s).min() < 1e-9
    assert np.abs(path.times - off_s).min() < 1e-9
    np.testing.assert_array_equal(path.jet_on, (path.times >= on_s - 1e-9) & (path.times <= off_s + 1e-9))


def test_strokes_that_meet_are_on_without_a_break_and_what_is_between_strokes_is_off() -> None:
    """On at 0, off and on again at 1, off at 2, on at 3 s."""
    moves = [MoveTo(time_s, (30.0 * time_s, 0.0, 50.0), DOWN, 30.0, "") for time_s in (0.0, 1.0, 2.0, 3.0, 4.0)]
    jets = [(0.0, True), (1.0, False), (1.0, True), (2.0, False), (3.0, True)]
    told = [*moves, *(SetNozzle(time_s, spraying, "") for time_s, spraying in jets)]
    nozzle = Command(0.0, "NOZZLE", ("ring60", "TOOL", "1"), "")
    path = sampled(program_of(nozzle, *sorted(told, key=lambda each: each.time_s)))
    off = (path.times > 2.0 + 1e-9) & (path.times < 3.0 - 1e-9)
    assert off.any()
    np.testing.assert_array_equal(path.jet_on, ~off)

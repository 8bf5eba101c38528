"""What the check of a long program takes in memory grows by little with each move."""

import tracemalloc
from dataclasses import replace

import pytest
from small_programs import program_of
from tracked import line_program

from programs.program import TimedProgram
from robotcell.cell.load import read_cell
from robotcell.motion import ladder_graph
from robotcell.robot import robot
from robotcell.track import Terms, track

SHORT, LONG = 4, 8
MOST_BYTES_PER_MOVE = 5000
"""Beyond the program itself, at the worst moment, which is no longer that of a piece: those became small."""


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let pieces be small beside the programs: theirs is the part that does not grow."""
    monkeypatch.setattr(robot, "_ROWS_AT_ONCE", 256)
    monkeypatch.setattr(ladder_graph, "_NODES_AT_ONCE", 64)


def repeated(times: int) -> TimedProgram:
    """The same strokes over and over."""
    once = line_program()
    lasting = once.totals.duration_s + 2.0
    return program_of(
        *(
            replace(item, time_s=item.time_s + number * lasting)
            for number in range(times)
            for item in once.instructions
        ),
        liquid=(("clean", 1.0),),
    )


def peak_bytes(program: TimedProgram, name: str) -> int:
    cell = read_cell(name).cell
    tracemalloc.start()
    report = track(program, cell, None, terms=Terms(frozenset({"ring60"})))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert report.possible
    return peak


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gantry", "ur5e-bench"])
def test_the_check_takes_little_memory_for_each_move(name: str) -> None:
    short, long = repeated(SHORT), repeated(LONG)
    peak_bytes(repeated(1), name)  # compiles, and fills the caches
    grown = peak_bytes(long, name) - peak_bytes(short, name)
    assert grown / (long.totals.moves - short.totals.moves) < MOST_BYTES_PER_MOVE

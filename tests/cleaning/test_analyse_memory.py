"""What the analysis of a long program takes in memory grows by little with each move."""

import tracemalloc
from dataclasses import replace

import pytest
from analysed import WASH, prepared_of, recipe_of

from cleaning.analyse import analyse_on
from programs.program import Command, TimedProgram
from rulesengine.planning.pipeline import run

SHORT, LONG = 2, 8
MOST_BYTES_PER_MOVE = 500
"""Beyond the program itself, at the worst moment."""


def repeated(program: TimedProgram, times: int) -> TimedProgram:
    """The same strokes over and over in one step of the recipe."""
    once, lasting = program.instructions, program.totals.duration_s + 1.0
    instructions = [
        replace(item, time_s=item.time_s + number * lasting)
        for number in range(times)
        for item in once
        if number == 0 or not isinstance(item, Command)
    ]
    moves = times * program.totals.moves
    totals = replace(program.totals, duration_s=times * lasting - 1.0, moves=moves)
    return replace(program, totals=totals, instructions=tuple(instructions))


@pytest.mark.slow
def test_the_analysis_takes_little_memory_for_each_move() -> None:
    prepared, recipe = prepared_of(("U1", "C1")), recipe_of(WASH)
    program = run(recipe, prepared.board).program
    peaks: list[int] = []
    for times in (1, SHORT, LONG):  # the first compiles, and fills the caches
        longer = repeated(program, times)
        tracemalloc.start()
        analyse_on(prepared, longer, recipe, "sketch")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    grown = (peaks[2] - peaks[1]) / ((LONG - SHORT) * program.totals.moves)
    assert grown < MOST_BYTES_PER_MOVE

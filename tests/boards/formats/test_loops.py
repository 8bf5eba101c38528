"""Loops out of the lines of a drawing, however often a line is drawn."""

import numpy as np

from boards.formats.loops import CHAIN_MM, chain

SQUARE = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [0.0, 30.0]])
EDGES = [np.array([SQUARE[at], SQUARE[(at + 1) % 4]]) for at in range(4)]


def test_lines_that_are_drawn_thousands_of_times_are_one() -> None:
    loops, opened = chain([edge[::turn] for edge in EDGES for turn in (1, -1) for _ in range(2000)])
    assert opened == []
    np.testing.assert_array_equal(loops[0], SQUARE)


def test_a_line_that_lies_upon_another_within_the_tolerance_is_left_out() -> None:
    loops, opened = chain([*EDGES, EDGES[0] + 0.4 * CHAIN_MM])
    assert opened == []
    np.testing.assert_array_equal(loops[0], SQUARE)
    _, opened = chain([*EDGES, EDGES[0] + 2.0 * CHAIN_MM])
    assert len(opened) == 1

"""Loops out of the lines of a drawing, however often a line is drawn."""

import numpy as np
import pytest
import shapely

import boards.formats.loops
from boards.formats.loops import CHAIN_MM, arc, chain, enclosed

SQUARE = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [0.0, 30.0]])
EDGES = [np.array([SQUARE[at], SQUARE[(at + 1) % 4]]) for at in range(4)]


@pytest.mark.slow
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


def test_a_body_that_is_drawn_thousands_of_times_is_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[int] = []
    union = shapely.union_all
    monkeypatch.setattr(
        boards.formats.loops.shapely, "union_all", lambda lines: computed.append(len(lines)) or union(lines)
    )
    body = enclosed([edge[::turn] for edge in EDGES for turn in (1, -1) for _ in range(2000)])
    assert body is not None
    assert body.area == 1200.0
    assert computed[0] == len(EDGES)


def test_scribbles_are_no_body_and_take_no_time() -> None:
    rng = np.random.default_rng(1)
    scribble = list(rng.uniform(0.0, 10.0, (600, 2, 2)))
    assert enclosed(scribble) is None
    assert enclosed([*EDGES, *scribble[:20]]) is not None


@pytest.mark.parametrize("radius", [1e9, 1e14, 1e17])
def test_an_arc_that_is_nearly_straight_has_few_points(radius: float) -> None:
    points = arc(np.array([0.0, 0.0]), np.array([0.0, radius]), 2e-9)
    assert 2 <= len(points) <= 10
    np.testing.assert_allclose(points[:, 1], 0.0, atol=max(1e-3, 1e-15 * radius))

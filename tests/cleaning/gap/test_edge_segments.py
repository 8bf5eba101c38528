from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rigid import Motion
from shapely import affinity, box
from small_boards import board_of, part

from boards.undersides.underside import GapCase, Underside
from cleaning.gap.edge_segments import SEGMENTS, build_edges


def under(component, turn_deg=0.0, inset=0.0):
    """The underside of a box that may be turned about its middle, without its leads."""
    straight = affinity.rotate(component.outline, -turn_deg, origin="centroid")
    x0, y0, x1, y1 = straight.bounds
    middle = component.outline.centroid
    size = (x1 - x0 - 2 * inset, y1 - y0 - 2 * inset)
    case = GapCase(0.1, ())
    return Underside(component.name, middle.x, middle.y, np.radians(turn_deg), *size, (case,), "stated", "stated")


def boxes(board):
    """A stand-in for the scene: rays in the plane against the straight boxes of all components, from wherever."""
    sides = [(c.outline.bounds, c.side, c.height_mm) for c in board.components]

    def cast(origins, directions):
        distance = np.full(len(origins), np.inf)
        for (x0, y0, x1, y1), side, height in sides:
            z = board.surface_z_mm(side)
            low, high = sorted([z, z + (height if side == "top" else -height)])
            lower, upper = np.array([x0, y0, low]), np.array([x1, y1, high])
            with np.errstate(divide="ignore", invalid="ignore"):
                a, b = (lower - origins) / directions, (upper - origins) / directions
            level = np.abs(directions) < 1e-12
            within = (origins > lower) & (origins < upper)
            near = np.where(level, np.where(within, -np.inf, np.inf), np.minimum(a, b)).max(axis=1)
            far = np.where(level, np.where(within, np.inf, -np.inf), np.maximum(a, b)).min(axis=1)
            hit = (near <= far) & (far > 0)
            distance = np.where(hit, np.minimum(distance, np.where(near > 0, near, far)), distance)
        return np.where(np.isfinite(distance), 0, -1), distance

    return cast


def edges_of(board, **how):
    return build_edges([under(each, **how) for each in board.components], board, boxes(board))


def test_segments_go_around_from_the_front_left():
    edges = edges_of(board_of(part("U1", 10, 20, 8, 4), surface_z=1.5))
    expected = [[12, 20], [16, 20], [18, 21], [18, 23], [16, 24], [12, 24], [10, 23], [10, 21]]
    np.testing.assert_allclose(edges.middles[0], np.column_stack([expected, np.full(8, 1.5)]))
    np.testing.assert_allclose(np.cross(edges.outward[0, :-1], edges.outward[0, 1:])[:, 2] >= 0, True)
    away = edges.middles[0, :, :2] - [14, 22]
    assert np.all(np.sum(away * edges.outward[0, :, :2], axis=1) > 0)


def test_a_lone_part_is_free_on_all_sides():
    edges = edges_of(board_of(part("U1", 10, 20, 8, 4)))
    assert np.all(np.isinf(edges.sheltered))


def test_a_neighbour_shelters_the_edge_that_faces_it():
    edges = edges_of(board_of(part("U1", 10, 20, 8, 4), part("C1", 21, 19, 2, 6)))
    assert edges.sheltered[0, [2, 3]] == pytest.approx(3.0)
    assert np.all(np.isinf(edges.sheltered[0, [0, 1, 4, 5, 6, 7]]))
    assert edges.sheltered[1, [6, 7]] == pytest.approx(3.0)


def test_a_neighbour_lower_than_half_the_part_does_not_shelter_it():
    edges = edges_of(board_of(part("U1", 10, 20, 8, 4, height=4.0), part("C1", 21, 19, 2, 6, height=1.0)))
    assert np.all(np.isinf(edges.sheltered[0]))
    assert edges.sheltered[1, [6, 7]] == pytest.approx(3.0)


def test_own_leads_do_not_shelter():
    edges = edges_of(board_of(part("U1", 10, 20, 8, 8), part("C1", 21, 19, 2, 10)), inset=1.5)
    assert edges.sheltered[0, [2, 3]] == pytest.approx(3.0 + 1.5)
    assert np.all(np.isinf(edges.sheltered[0, [0, 1, 4, 5, 6, 7]]))


def test_the_bottom_side_lies_below():
    edges = edges_of(board_of(part("U1", 10, 20, 8, 4), part("U2", 21, 20, 8, 4, side="bottom"), surface_z=0.5))
    assert edges.facing.tolist() == [1.0, -1.0]
    assert edges.middles[1, :, 2] == pytest.approx(0.5 - 1.6)
    assert np.all(np.isinf(edges.sheltered))


def test_a_board_without_gaps_has_no_edges():
    board = board_of(part("U1", 10, 20, 8, 4))
    edges = build_edges((), board, boxes(board))
    assert edges.middles.shape == (0, SEGMENTS, 3)
    assert edges.sheltered.shape == (0, SEGMENTS)


@settings(max_examples=20)
@given(turn=st.floats(-180.0, 180.0), x=st.floats(-50.0, 50.0), y=st.floats(-50.0, 50.0))
def test_segments_move_with_the_part(turn, x, y):
    still = part("U1", 10, 20, 8, 4)
    motion = Motion(turn, (x, y, 0.0))
    moved = replace(still, outline=affinity.translate(affinity.rotate(still.outline, turn, origin=(0, 0)), x, y))
    board = board_of(moved, outline=box(-200, -200, 200, 200))
    edges = build_edges([under(moved, turn)], board, lambda o, d: (np.full(len(o), -1), np.zeros(len(o))))
    before = edges_of(board_of(still))
    np.testing.assert_allclose(edges.middles, motion.points(before.middles), atol=1e-9)
    np.testing.assert_allclose(edges.outward, before.outward @ motion.matrix.T, atol=1e-9)

"""Transfers clear what stands below them, and go around the edge when the board is turned over."""

import numpy as np
import pytest
from shapely import LineString, box
from small_boards import board_of, part

from recipes.recipe import Limits
from rulesengine.planning.board_job import BoardWays, free_way
from rulesengine.strokes.laid import Pose
from rulesengine.strokes.safe_height import floors

DOWN = np.array([0.0, 0.0, -1.0])
ALONG = np.array([1.0, 0.0, 0.0])
WALL = part("J1", 40, 0, 10, 60, 30)


def pose(x, y, z):
    return Pose(np.array([x, y, z], dtype=float), DOWN, ALONG)


def ways_of(board, side="top", limits=None):
    return BoardWays(board, limits or Limits(), side, floors(board, side, 5))


def test_straight_where_nothing_is_in_the_way():
    clear = floors(board_of(WALL), "top", 5)
    assert len(free_way(pose(0, 10, 20), pose(30, 10, 20), clear, "corridor")) == 2
    assert len(free_way(pose(0, 10, 36), pose(90, 10, 36), clear, "corridor")) == 2


def test_up_over_and_down_where_a_body_stands_between():
    board = board_of(WALL)
    poses = free_way(pose(0, 10, 20), pose(90, 10, 25), floors(board, "top", 5), "corridor")
    path = np.array([each.tcp for each in poses])
    assert path[:, 2] == pytest.approx([20, 35, 35, 25], abs=0.1)
    assert path[1, 2] >= 35
    np.testing.assert_allclose(path[[1, 2], :2], path[[0, 3], :2])


@pytest.mark.parametrize("retract", ["corridor", "everything"])
@pytest.mark.parametrize("side", ["top", "bottom"])
def test_a_way_over_a_body_lies_higher_by_what_its_corners_are_cut(side, retract):
    clear = floors(board_of(part("J1", 40, 0, 10, 60, 30, side=side)), side, 5, blend_mm=0.5)
    assert clear.corner_mm > 0.5
    there, back = pose(0, 10, 20), pose(90, 10, 25)
    for ends in ((there, back), (back, there)):
        heights = [each.tcp[2] for each in free_way(*ends, clear, retract)]
        over = clear.highest + clear.corner_mm
        assert heights == pytest.approx([ends[0].tcp[2], over, over, ends[1].tcp[2]])


def test_above_everything_even_where_nothing_is_below():
    clear = floors(board_of(WALL), "top", 5)
    poses = free_way(pose(0, 10, 20), pose(30, 10, 20), clear, "everything")
    assert max(each.tcp[2] for each in poses) >= 35


def test_nothing_to_do_is_no_transfer():
    clear = floors(board_of(WALL), "top", 5)
    assert free_way(pose(0, 10, 20), pose(0, 10, 20), clear, "everything") == []


def test_turning_on_the_spot_needs_no_retract():
    clear = floors(board_of(WALL), "top", 5)
    leaning = Pose(np.array([0.0, 10.0, 20.0]), np.array([0.6, 0.0, -0.8]), np.array([0.8, 0.0, 0.6]))
    assert len(free_way(pose(0, 10, 20), leaning, clear, "everything")) == 2


def test_parks_above_everything():
    board = board_of(part("J1", 45, 25, 10, 10, 200))
    home = ways_of(board).parked
    assert home.tcp[:2] == pytest.approx([50, 30])
    assert home.tcp[2] >= 205
    low = ways_of(board_of(), limits=Limits(park_mm=(3, 4))).parked
    assert low.tcp.tolist() == [3, 4, 110]


def test_way_to_the_other_side_leads_around_the_edge():
    board = board_of(WALL, part("U1", 10, 10, 20, 20, 8, side="bottom"))
    limits = Limits()
    top, bottom = (ways_of(board, side, limits) for side in ("top", "bottom"))
    way = bottom.turn_over(top, top.parked, 100, "sequence[1]/turn")
    assert way.approach[0].tolist() == [0, 0, -1]
    assert way.approach[-1].tolist() == [0, 0, 1]
    assert np.sum(way.approach * way.reference, axis=1) == pytest.approx(0)
    for a, b in zip(way.tcp[:-1], way.tcp[1:], strict=True):
        between = np.linspace(a, b, 200)
        level = (between[:, 2] > -10) & (between[:, 2] < 31)
        assert all(LineString([p[:2], p[:2] + 1e-9]).distance(box(0, 0, 100, 60)) >= 5 for p in between[level])

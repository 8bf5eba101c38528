"""Board perimeters follow the real edge."""

import numpy as np
import pytest
from shapely import LinearRing, box
from sites import site_on
from small_boards import board_of, l_shape

from recipes.paths import BoardPerimeter
from rulesengine.paths.board_perimeter import plan_board_perimeter


def planned(outline, **changes):
    spec = BoardPerimeter(**({"height_mm": 60, "speed_mm_s": 80} | changes))
    return plan_board_perimeter(spec, site_on(board_of(outline=outline))).strokes


@pytest.mark.parametrize("offset", [5, 0, -5])
def test_follows_a_bent_edge_at_its_offset(offset):
    (stroke,) = planned(l_shape(), offset_mm=offset)
    expected = l_shape().buffer(offset, join_style="mitre").exterior
    assert LinearRing(stroke.tcp[:, :2]).hausdorff_distance(expected) < 1e-6


@pytest.mark.parametrize(("direction", "ccw"), [("counterclockwise", True), ("clockwise", False)])
def test_goes_round_in_the_sense_asked_for_and_leans_inside(direction, ccw):
    (stroke,) = planned(box(0, 0, 100, 60), tilt_deg=20, toward="inside", direction=direction)
    assert LinearRing(stroke.tcp[:, :2]).is_ccw == ccw
    inward = np.array([50, 30]) - stroke.tcp[:, :2]
    assert (np.sum(inward * stroke.approach[:, :2], axis=1) > 0).all()


def test_pauses_at_each_corner_without_turning_when_upright():
    (stroke,) = planned(box(0, 0, 100, 60), corner_delay_s=0.2)
    assert len(stroke.tcp) == 4
    assert stroke.delays.tolist() == [0.2] * 4


def test_round_corners_are_followed_without_a_pause():
    (stroke,) = planned(box(0, 0, 100, 60).buffer(8), corner_delay_s=0.2, tilt_deg=20)
    assert (stroke.delays == 0).all()
    assert len(stroke.entries) <= 8


def test_begins_at_the_corner_asked_for():
    (stroke,) = planned(box(0, 0, 100, 60), start="back_right", tilt_deg=20)
    assert stroke.tcp[stroke.entries[0], :2].tolist() == [100, 60]


def test_cutouts_are_followed_if_asked():
    holed = box(0, 0, 100, 60).difference(box(30, 20, 50, 40))
    assert len(planned(holed)) == 1
    outer, hole = planned(holed, follow="outline_and_cutouts")
    assert LinearRing(hole.tcp[:, :2]).hausdorff_distance(box(30, 20, 50, 40).exterior) < 1e-6
    assert LinearRing(outer.tcp[:, :2]).hausdorff_distance(box(0, 0, 100, 60).exterior) < 1e-6


def test_offset_that_swallows_the_board_falls_back_to_its_edge():
    (stroke,) = planned(box(0, 0, 100, 10), offset_mm=-20)
    assert LinearRing(stroke.tcp[:, :2]).hausdorff_distance(box(0, 0, 100, 10).exterior) < 1e-6


def test_no_repeats_is_no_path():
    assert planned(box(0, 0, 100, 60), repeats=0) == ()

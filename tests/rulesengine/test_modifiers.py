"""Strokes are raised over bodies and cut where they must not spray."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon, affinity, box
from sites import CONE, site_on
from small_boards import board_of, part

from recipes.classes import Mask
from recipes.load import load_recipe
from recipes.paths import BoardPerimeter, ComponentPerimeter, StraightLine
from rulesengine.modifiers import avoided_zone, keep_out, raise_over
from rulesengine.paths.board_perimeter import plan_board_perimeter
from rulesengine.paths.component_perimeter import plan_component_perimeter
from rulesengine.paths.straight_line import plan_straight_line
from rulesengine.strokes.classify import read_masks
from rulesengine.strokes.safe_height import floors
from rulesengine.strokes.stroke import StrokeSet
from specs.source import Source


def line_over(board, height=20.0, **changes):
    spec = StraightLine(**({"from_mm": (0, 30), "to_mm": (100, 30), "height_mm": height, "speed_mm_s": 40} | changes))
    return plan_straight_line(spec, site_on(board)).strokes[0]


def raised(stroke, over):
    done = raise_over(StrokeSet((stroke,), "fixed"), over)
    return done.strokes[0], done.findings


def distance_to_prism(points, outline, height):
    plan = np.array([outline.distance(Polygon.from_bounds(x, y, x, y).centroid) for x, y in points[:, :2]])
    return np.hypot(plan, np.maximum(points[:, 2] - height, 0))


def dense(tcp, step=0.1):
    points = [tcp[:1]]
    for a, b in pairwise(tcp):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        points.append(a + (b - a) * (np.arange(1, count + 1) / count)[:, None])
    return np.concatenate(points)


@pytest.mark.slow
@given(
    height=st.floats(5, 60),
    x=st.floats(15, 60),
    width=st.floats(1, 30),
    clearance=st.floats(1, 12),
    gap=st.floats(0, 20),
)
@settings(max_examples=40)
def test_raised_line_keeps_its_clearance_everywhere(height, x, width, clearance, gap):
    tall = part("J1", x, 25, width, 10, height)
    second = part("J2", x + width + gap, 32, 5, 5, height * 0.7)
    board = board_of(tall, second)
    stroke, _ = raised(line_over(board), floors(board, "top", clearance))
    points = dense(stroke.tcp)
    for body in (tall, second):
        assert distance_to_prism(points, body.outline, body.height_mm).min() >= clearance - 1e-6


def test_raising_keeps_plan_view_slope_and_says_where():
    board = board_of(part("J1", 40, 25, 20, 10, 30))
    flat = line_over(board)
    stroke, (finding,) = raised(flat, floors(board, "top", 5))
    assert stroke.tcp[:, 1] == pytest.approx(30)
    assert stroke.tcp[:, 2].max() == pytest.approx(35, abs=0.1)
    rise = np.abs(np.diff(stroke.tcp[:, 2]))
    run = np.diff(stroke.tcp[:, 0])
    assert (rise <= run + 1e-6).all()
    assert finding.rule.id == "raised-over-body"
    assert 34.8 <= finding.where[0] <= 65.2


def test_what_is_clear_stays_the_same_object():
    board = board_of(part("J1", 40, 25, 20, 10, 10))
    flat = line_over(board)
    stroke, findings = raised(flat, floors(board, "top", 5))
    assert stroke is flat
    assert findings == ()


def test_ring_is_raised_across_its_beginning():
    board = board_of(part("J1", -2, -2, 6, 6, 80))
    spec = BoardPerimeter(height_mm=40, speed_mm_s=40, tilt_deg=20)
    (ring,) = plan_board_perimeter(spec, site_on(board)).strokes
    stroke, findings = raised(ring, floors(board, "top", 5))
    assert len(findings) == 1
    around = dense(np.vstack([stroke.tcp, stroke.tcp[:1]]))
    assert distance_to_prism(around, box(-2, -2, 4, 4), 80).min() >= 5 - 1e-6
    assert around[:, 2].min() == pytest.approx(40)
    np.testing.assert_allclose(stroke.tcp[list(stroke.entries), :2], ring.tcp[list(ring.entries), :2])
    assert stroke.delays.sum() == ring.delays.sum()


def masked(board, strokes, *masks):
    recipe = load_recipe("smt-aqueous").model_copy(update={"masks": list(masks)})
    read, _ = read_masks(recipe, board)
    return keep_out(strokes, avoided_zone(board, "top", read), CONE, Source(0, "path"))


def test_what_hangs_over_the_edge_below_is_avoided_from_above_too():
    board = board_of(part("J1", 90, 20, 20, 10, side="bottom"), part("C1", 40, 20, 2, 1, side="bottom"))
    recipe = load_recipe("smt-aqueous").model_copy(update={"masks": [Mask(avoid=["*"], margin_mm=2.0)]})
    masks, _ = read_masks(recipe, board)
    zone = avoided_zone(board, "top", masks)
    assert zone.covers(box(100.1, 20, 110, 30).buffer(2.0))  # beyond the edge, which is at 100 mm
    assert not zone.intersects(box(0, 0, 97, 60))  # the board shields the rest of J1, and all of C1
    below = avoided_zone(board, "bottom", masks)
    assert below.covers(box(90, 20, 110, 30).buffer(2.0))
    assert below.covers(box(40, 20, 42, 21).buffer(2.0))


def test_footprint_never_touches_what_is_avoided():
    board = board_of(part("MK1", 45, 28, 4, 4))
    spec = StraightLine(from_mm=(0, 30), to_mm=(100, 30), height_mm=20, speed_mm_s=40)
    cut = masked(board, plan_straight_line(spec, site_on(board)), Mask(avoid=["MK*"], margin_mm=2.5))
    reach = 20 * np.tan(np.radians(36)) + 2.5
    assert len(cut.strokes) == 2
    sprayed = [LineString(stroke.tcp[:, :2]) for stroke in cut.strokes]
    assert min(line.distance(box(45, 28, 49, 32)) for line in sprayed) >= reach - 1e-6
    assert min(line.distance(box(45, 28, 49, 32)) for line in sprayed) <= reach + 1.2
    assert [finding.rule.id for finding in cut.findings] == ["cut-by-mask"]
    left_mm = sum(line.length for line in sprayed)
    assert f"{1.0 - left_mm / 100.0:.0%} of the way is left out" in cut.findings[0].message
    assert cut.findings[0].severity == "warning"
    shorter = masked(
        board_of(part("MK1", 45, 28, 4, 4)),
        plan_straight_line(spec.model_copy(update={"height_mm": 2.0}), site_on(board)),
        Mask(avoid=["MK*"], margin_mm=0.1),
    )
    assert shorter.findings[0].severity == "info"


def test_rest_of_just_the_shortest_length_stays_however_the_board_lies():
    radius = 20 * np.tan(np.radians(36))
    board, zone = board_of(part("U1", 20, 20, 4, 4)), box(radius + 31.2, -1, 99, 1)
    kept = set()
    for turn in np.radians(np.arange(0, 360, 7)):
        along = np.array([np.cos(turn), np.sin(turn)])
        stroke = line_over(board, from_mm=tuple(30 * along), to_mm=tuple(100 * along))
        there = affinity.rotate(zone, turn, origin=(0, 0), use_radians=True)
        cut = keep_out(StrokeSet((stroke,), "fixed"), there, CONE, Source(0, "path"))
        kept.add(tuple(round(float(np.ptp(np.hypot(*each.tcp[:, :2].T))), 6) for each in cut.strokes))
    assert kept == {(1.0,)}


def test_ring_that_loses_a_part_is_done_as_often_as_it_was():
    board = board_of(part("U1", 20, 20, 40, 20), part("MK1", 70, 28, 4, 4))
    spec = ComponentPerimeter(height_mm=10, speed_mm_s=40, tilt_deg=35, passes=3)
    planned = plan_component_perimeter(spec, site_on(board, served=["U1"]))
    cut = masked(board, planned, Mask(avoid=["MK1"]))
    places = {tuple(np.round(stroke.tcp[0], 6)) for stroke in cut.strokes}
    assert len(cut.strokes) == 3 * len(places)
    assert all(not stroke.closed and stroke.laps == 1 for stroke in cut.strokes)


def test_part_that_cannot_be_served_is_named():
    board = board_of(part("C1", 47, 28, 2, 1), part("MK1", 50, 28, 4, 4))
    spec = ComponentPerimeter(height_mm=20, speed_mm_s=40, tilt_deg=35)
    planned = plan_component_perimeter(spec, site_on(board, served=["C1"]))
    cut = masked(board, planned, Mask(avoid=["MK1"]))
    assert cut.strokes == ()
    assert "C1" in cut.findings[-1].message


def test_no_mask_changes_nothing():
    board = board_of(part("C1", 47, 28, 2, 1))
    planned = plan_component_perimeter(ComponentPerimeter(height_mm=20, speed_mm_s=40), site_on(board))
    assert masked(board, planned) is planned

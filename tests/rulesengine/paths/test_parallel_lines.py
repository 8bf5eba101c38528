"""Raster, final flush, step function and straight line."""

import numpy as np
import pytest
from shapely import LineString, Polygon, box, unary_union
from sites import site_on
from small_boards import board_of, l_shape, part

from recipes.footprint import core_footprint
from recipes.nozzles import FlatFan
from recipes.paths import FinalFlush, Raster, StepFunction, StraightLine
from rulesengine.modifiers import pause_at_edges
from rulesengine.paths.final_flush import plan_final_flush
from rulesengine.paths.raster import plan_raster
from rulesengine.paths.step_function import plan_step_function
from rulesengine.paths.straight_line import plan_straight_line
from rulesengine.strokes.stroke import reference_axes

SLOTTED = box(0, 0, 120, 80).difference(box(20, -1, 100, 60))


def sprayed(site, strokes):
    """Union of the footprints along the strokes."""
    swaths = []
    for stroke in strokes:
        for index in range(len(stroke.tcp) - 1):
            reference = reference_axes(stroke.approach[[index]], stroke.azimuth[[index]])[0]
            outline = core_footprint(site.nozzle, stroke.tcp[index, 2], stroke.approach[index], reference)
            ends = [Polygon(outline + stroke.tcp[i, :2]).buffer(0) for i in (index, index + 1)]
            if np.allclose(stroke.approach[index], stroke.approach[index + 1]):
                swaths.append(unary_union(ends).convex_hull)
            else:
                swaths += ends
    return unary_union(swaths)


@pytest.mark.parametrize("outline", [box(0, 0, 100, 60), l_shape(150.0), SLOTTED])
@pytest.mark.parametrize("direction", [0, 30, 90, "longest_edge"])
@pytest.mark.parametrize(("tilt", "toward"), [(0, "travel"), (25, "travel"), (20, "left"), (35, "against_travel")])
def test_raster_wets_the_whole_board(outline, direction, tilt, toward):
    site = site_on(board_of(outline=outline))
    spec = Raster(height_mm=40, speed_mm_s=60, direction_deg=direction, margin_mm=5, tilt_deg=tilt, toward=toward)
    wet = sprayed(site, plan_raster(spec, site).strokes)
    target = outline.buffer(-5, join_style="mitre")
    assert target.difference(wet).area <= 0.005 * target.area


def test_raster_goes_back_and_forth_in_one_stroke():
    site = site_on(board_of())
    spec = Raster(height_mm=40, speed_mm_s=60, edge_delay_s=0.5, overlap=0.5)
    (stroke,) = plan_raster(spec, site).strokes
    lines = stroke.tcp.reshape(-1, 2, 3)
    assert np.sign(lines[:, 1, 0] - lines[:, 0, 0]).tolist() == [1, -1, 1]
    assert stroke.delays.tolist() == [0, 0.5] * 3
    pitch = np.diff(lines[:, 0, 1])
    assert (pitch <= 0.5 * 2 * 40 * np.tan(np.radians(30)) + 1e-9).all()


def test_raster_on_a_board_that_breaks_stripes_is_free_to_order_them():
    planned = plan_raster(Raster(height_mm=20, speed_mm_s=60), site_on(board_of(outline=SLOTTED)))
    assert planned.freedom == "free"
    assert len(planned.strokes) > 3


def test_margin_that_leaves_nothing_is_reduced_and_said():
    site = site_on(board_of(outline=box(0, 0, 100, 12)))
    planned = plan_raster(Raster(height_mm=40, speed_mm_s=60, margin_mm=10), site)
    assert len(planned.strokes) == 1
    assert [finding.rule.id for finding in planned.findings] == ["margin-reduced"]


def test_pitch_wider_than_the_footprint_is_said():
    planned = plan_raster(Raster(height_mm=20, speed_mm_s=60, pitch_mm=40), site_on(board_of()))
    assert [finding.rule.id for finding in planned.findings] == ["pitch-too-wide"]


def test_fan_lies_across_the_travel():
    site = site_on(board_of(), nozzle=FlatFan(half_angle_deg=30, flow_lpm=1))
    (stroke,) = plan_raster(Raster(height_mm=40, speed_mm_s=60, direction_deg=90), site).strokes
    assert np.abs(stroke.azimuth[:, 0]) == pytest.approx(1)


def test_flush_runs_one_way_and_returns_above_everything():
    site = site_on(board_of())
    planned = plan_final_flush(FinalFlush(height_mm=30, speed_mm_s=50, direction_deg=90, tilt_deg=35), site)
    assert planned.retract == "everything"
    assert len(planned.strokes) > 2
    assert all(stroke.tcp[1, 1] > stroke.tcp[0, 1] for stroke in planned.strokes)
    assert all(stroke.approach[0, 1] > 0 for stroke in planned.strokes)
    across = [stroke.tcp[0, 0] for stroke in planned.strokes]
    assert across == sorted(across, reverse=True)


def test_flush_begins_with_the_last_line_if_asked():
    site = site_on(board_of())
    first, last = (
        plan_final_flush(FinalFlush(height_mm=30, speed_mm_s=50, start=start), site) for start in ("first", "last")
    )
    assert [s.tcp[0, 1] for s in first.strokes] == [s.tcp[0, 1] for s in last.strokes][::-1]
    assert first.freedom == last.freedom == "fixed"


def stepped(spec, site):
    """Strokes of a step function with their pauses."""
    return pause_at_edges(plan_step_function(spec, site), site.board).strokes


def test_step_pauses_once_at_each_edge_in_order():
    parts = [part("C1", 10, 28, 4, 4), part("U1", 30, 20, 20, 20, pins=48), part("C2", 70, 29, 3, 2)]
    site = site_on(board_of(*parts))
    spec = StepFunction(height_mm=60, speed_mm_s=50, delay_s={"any": 0.4}, overlap=0)
    (stroke,) = stepped(spec, site)
    assert stroke.tcp[:, 1] == pytest.approx(30)
    assert stroke.tcp[1:-1, 0] == pytest.approx([10, 14, 30, 50, 70, 73])
    assert stroke.pauses == ("", "C1", "C1", "U1", "U1", "C2", "C2", "")
    assert stroke.delays.tolist() == [0, *[0.4] * 6, 0]


def test_step_counts_every_edge_of_a_concave_part_and_shared_edges_twice():
    u_shape = Polygon([(20, 10), (60, 10), (60, 50), (50, 50), (50, 20), (30, 20), (30, 50), (20, 50)])
    from dataclasses import replace

    bent = replace(part("U1", 0, 0, 1, 1), outline=u_shape, footprint=u_shape)
    touching = part("C1", 60, 25, 5, 10)
    site = site_on(board_of(bent, touching))
    (stroke,) = stepped(StepFunction(height_mm=60, speed_mm_s=50, overlap=0), site)
    assert stroke.tcp[1:-1, 0] == pytest.approx([20, 30, 50, 60, 60, 65])


def test_tilted_step_pauses_where_the_axis_crosses_the_edge():
    site = site_on(board_of(part("U1", 30, 20, 20, 20)))
    spec = StepFunction(height_mm=60, speed_mm_s=50, tilt_deg=20, overlap=0)
    (stroke,) = stepped(spec, site)
    axis = stroke.tcp[:, 0] + 60 * np.tan(np.radians(20))
    assert axis[1:-1] == pytest.approx([30, 50])


def test_parts_that_are_not_served_get_no_pause():
    site = site_on(board_of(part("U1", 30, 20, 20, 20)), served=())
    (stroke,) = stepped(StepFunction(height_mm=60, speed_mm_s=50, overlap=0), site)
    assert len(stroke.tcp) == 2


def test_straight_line_leads_the_axis_from_point_to_point_and_back():
    spec = StraightLine(from_mm=(10, 20), to_mm=(60, 20), height_mm=50, speed_mm_s=40, tilt_deg=30, repeats=2)
    there, back = plan_straight_line(spec, site_on(board_of())).strokes
    reach = 50 * np.tan(np.radians(30))
    assert there.tcp[:, 0] == pytest.approx([10 - reach, 60 - reach])
    assert back.tcp[:, 0] == pytest.approx([60 + reach, 10 + reach])


def test_overshoot_runs_on_at_both_ends():
    spec = StraightLine(from_mm=(10, 20), to_mm=(60, 20), height_mm=50, speed_mm_s=40, overshoot_mm=7)
    (stroke,) = plan_straight_line(spec, site_on(board_of())).strokes
    assert LineString(stroke.tcp[:, :2]).bounds == pytest.approx((3, 20, 67, 20))

"""Component perimeters go around, lean the right way, and put the wave front on the edge."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import LinearRing, Point, Polygon, box
from sites import CONE, site_on
from small_boards import board_of, l_shape, part

from recipes.nozzles import FlatFan
from recipes.paths import ComponentPerimeter, Near
from rulesengine.paths.component_perimeter import plan_component_perimeter

EXACT_MM = 0.01  # the footprint is known at so many rays; between two of them it is this exact


def spec_with(**changes):
    known = {"height_mm": 40, "speed_mm_s": 40, "tilt_deg": 35}
    return ComponentPerimeter(**(known | changes))


def ring_of(stroke):
    return LinearRing(stroke.tcp[:, :2])


def test_near_wave_front_lies_on_the_edge():
    board = board_of(part("U1", 40, 20, 12, 8))
    (stroke,) = plan_component_perimeter(spec_with(), site_on(board)).strokes
    reach = 40 * np.tan(np.radians(35 - 30))
    expected = box(40, 20, 52, 28).buffer(reach, join_style="mitre")
    assert ring_of(stroke).hausdorff_distance(expected.exterior) < EXACT_MM
    assert stroke.tcp[:, 2] == pytest.approx(40)


@pytest.mark.parametrize("tilt", [35, 42])
@pytest.mark.parametrize("distance", [0, 2])
@pytest.mark.parametrize(("toward", "align"), [(a, b) for a in ("component", "away") for b in ("wavefront", "axis")])
def test_what_is_aligned_meets_the_edge_whichever_way_the_jet_leans(toward, align, tilt, distance):
    outline = box(20, 20, 80, 60)
    spec = spec_with(height_mm=20, toward=toward, align=align, tilt_deg=tilt, distance_mm=distance)
    (stroke,) = plan_component_perimeter(spec, site_on(board_of(part("U1", 20, 20, 60, 40)))).strokes
    reach = 20 * np.tan(np.radians(tilt - 30 if align == "wavefront" else tilt))
    aligned = LinearRing(outline.buffer(distance, join_style="mitre").exterior.coords)
    for begin in range(0, len(stroke.tcp), 2):
        middle, jet = stroke.tcp[begin : begin + 2].mean(axis=0), stroke.approach[begin]
        meets = middle[:2] + reach * jet[:2] / np.linalg.norm(jet[:2])
        assert aligned.distance(Point(meets)) < EXACT_MM


def test_axis_alignment_and_distance_move_the_path_out():
    board = board_of(part("U1", 40, 20, 12, 8))
    (stroke,) = plan_component_perimeter(spec_with(align="axis", distance_mm=3), site_on(board)).strokes
    reach = 40 * np.tan(np.radians(35)) + 3
    assert Polygon(stroke.tcp[:, :2]).bounds == pytest.approx((40 - reach, 20 - reach, 52 + reach, 28 + reach))


@pytest.mark.parametrize("toward", ["component", "away"])
def test_jet_leans_to_or_from_the_component(toward):
    board = board_of(part("U1", 40, 20, 12, 8))
    (stroke,) = plan_component_perimeter(spec_with(toward=toward, align="axis", distance_mm=60), site_on(board)).strokes
    inward = np.array([46, 24]) - stroke.tcp[:, :2]
    lean = np.sum(inward * stroke.approach[:, :2], axis=1)
    assert (lean > 0).all() if toward == "component" else (lean < 0).all()
    assert stroke.approach[:, 2] == pytest.approx(-np.cos(np.radians(35)))


def test_every_edge_ends_with_a_pause_and_a_turn_on_the_spot():
    board = board_of(part("U1", 40, 20, 12, 8))
    (stroke,) = plan_component_perimeter(spec_with(edge_delay_s=0.5), site_on(board)).strokes
    assert stroke.delays.tolist() == [0, 0.5] * 4
    np.testing.assert_allclose(stroke.tcp[1::2], np.roll(stroke.tcp[0::2], -1, axis=0))
    assert len(stroke.entries) == 4
    assert all(entry % 2 == 0 for entry in stroke.entries)


def test_laps_follow_the_class_and_close_neighbours_change_them():
    board = board_of(part("C1", 10, 10, 2, 1), part("C2", 15, 10, 2, 1), part("R1", 60, 40, 2, 1))
    near = Near(within_mm=3.5, passes=5, speed_mm_s=10)
    planned = plan_component_perimeter(spec_with(passes={"any": 3}, near=near), site_on(board))
    assert [(str(s.made_by), s.laps, s.speed_mm_s) for s in planned.strokes] == [
        ("sequence[0]/path/C1", 5, 10),
        ("sequence[0]/path/C2", 5, 10),
        ("sequence[0]/path/R1", 3, 40),
    ]


def test_close_components_are_followed_as_one_outline():
    parts = [part("C1", 10, 10, 2, 1), part("C2", 13, 10, 2, 1), part("C3", 16, 10.5, 2, 1), part("U1", 50, 30, 8, 8)]
    strokes = plan_component_perimeter(spec_with(merge_gap_mm=1.5), site_on(board_of(*parts))).strokes
    assert [stroke.made_by.components for stroke in strokes] == [("C1", "C2", "C3"), ("U1",)]
    around = Polygon(strokes[0].tcp[:, :2])
    assert all(around.contains(each.outline) for each in parts[:3])


def test_too_little_tilt_is_said_and_the_outline_is_followed():
    board = board_of(part("U1", 40, 20, 12, 8))
    planned = plan_component_perimeter(spec_with(tilt_deg=10), site_on(board))
    assert [finding.rule.id for finding in planned.findings] == ["wavefront-behind-nozzle"]
    assert ring_of(planned.strokes[0]).hausdorff_distance(box(40, 20, 52, 28).exterior) < 1e-6


def test_path_inside_that_does_not_exist_is_said():
    board = board_of(part("C1", 40, 20, 2, 1))
    planned = plan_component_perimeter(spec_with(align="axis", tilt_deg=0, distance_mm=-5), site_on(board))
    assert "no-path-inside" in [finding.rule.id for finding in planned.findings]
    assert Polygon(planned.strokes[0].tcp[:, :2]).contains(Point(41, 20.5))


def test_narrow_corridors_are_one_finding_that_names_the_narrowest():
    parts = [part("C1", 10, 10, 2, 1), part("C2", 16, 10, 2, 1), part("C3", 40, 10, 2, 1)]
    findings = plan_component_perimeter(spec_with(), site_on(board_of(*parts))).findings
    (corridor,) = [finding for finding in findings if finding.rule.id == "narrow-corridor"]
    assert "between C1 and C2" in corridor.message
    assert "Narrowest 4.00 mm" in corridor.message


def test_only_serves_the_classes_it_names_and_zero_passes_serve_nobody():
    board = board_of(part("U1", 40, 20, 12, 8))
    assert plan_component_perimeter(spec_with(only=["other"]), site_on(board)).strokes == ()
    assert plan_component_perimeter(spec_with(passes=0), site_on(board)).strokes == ()


def test_inner_corner_is_followed_too():
    shape = part("U1", 0, 0, 1, 1)
    bent = l_shape(20.0)
    board = board_of(replace(shape, footprint=bent, outline=bent, area_mm2=bent.area))
    (stroke,) = plan_component_perimeter(spec_with(), site_on(board)).strokes
    reach = 40 * np.tan(np.radians(5))
    assert ring_of(stroke).hausdorff_distance(bent.buffer(reach, join_style="mitre").exterior) < EXACT_MM


def test_fan_turns_with_the_edge_and_a_cone_does_not():
    board = board_of(part("U1", 40, 20, 12, 8))
    fan = FlatFan(half_angle_deg=20, flow_lpm=1)
    (turning,) = plan_component_perimeter(spec_with(), site_on(board, nozzle=fan)).strokes
    (still,) = plan_component_perimeter(spec_with(), site_on(board, nozzle=CONE)).strokes
    assert len(np.unique(np.round(turning.azimuth, 6), axis=0)) == 4
    assert len(np.unique(np.round(still.azimuth, 6), axis=0)) == 1

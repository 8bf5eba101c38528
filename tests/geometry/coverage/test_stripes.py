"""Stripes serve the whole region, whatever its shape and direction."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon, box, unary_union

from geometry.coverage.stripes import stripes

SHAPES = [
    box(0, 0, 100, 60),
    Polygon([(0, 0), (60, 0), (60, 30), (30, 30), (30, 60), (0, 60)]),
    Polygon([(0, 0), (80, 10), (50, 70)]),
    box(0, 0, 90, 60).difference(box(30, 20, 60, 40)),
]


@pytest.mark.slow
@given(shape=st.sampled_from(SHAPES), angle=st.floats(-180, 180), pitch=st.floats(2, 40))
@settings(max_examples=60)
def test_a_swath_as_wide_as_the_pitch_covers_the_region(shape, angle, pitch):
    direction = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    lines = [LineString(s) for row in stripes(shape, direction, pitch, 0.0) for s in row.stretches]
    swaths = unary_union([line.buffer(pitch / 2 + 1e-6, cap_style="flat") for line in lines])
    # What reaches less than a micrometre into a band has no stripe there.
    assert shape.difference(swaths.buffer(1.1e-3)).area < 1e-3


def test_lines_run_along_the_direction_from_right_to_left():
    rows = stripes(box(0, 0, 100, 60), np.array([0.0, 1.0]), 30, 0)
    assert [row.stretches[0][0, 0] for row in rows] == pytest.approx([87.5, 62.5, 37.5, 12.5])
    assert all(stretch[1, 1] > stretch[0, 1] for row in rows for stretch in row.stretches)


def test_gap_is_left_out_unless_it_is_short():
    frame = box(0, 0, 90, 20).difference(box(30, -1, 60, 21))
    direction = np.array([1.0, 0.0])
    assert [len(row.stretches) for row in stripes(frame, direction, 20, 10)] == [2]
    assert [len(row.stretches) for row in stripes(frame, direction, 20, 31)] == [1]


def test_turned_region_gives_turned_stripes():
    angle = np.radians(37)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shape = SHAPES[1]
    turned = Polygon(np.array(shape.exterior.coords) @ turn.T)
    straight = [s for row in stripes(shape, np.array([1.0, 0.0]), 7, 0) for s in row.stretches]
    leaning = [s for row in stripes(turned, turn @ [1.0, 0.0], 7, 0) for s in row.stretches]
    np.testing.assert_allclose(np.array(straight) @ turn.T, leaning, atol=1e-9)


@pytest.mark.parametrize("nudge", [-1e-10, 0.0, 1e-10])
def test_last_bits_do_not_decide_where_a_band_ends_at_a_hole(nudge):
    frame = box(0, 0, 90, 30).difference(box(30, 10 + nudge, 60, 20 - nudge))
    rows = stripes(frame, np.array([1.0, 0.0]), 10, 5)
    assert [len(row.stretches) for row in rows] == [1, 2, 1]


@given(shape=st.sampled_from(SHAPES), angle=st.floats(-180, 180), spread=st.floats(0.3, 1))
@settings(max_examples=40)
def test_stripes_that_are_drawn_together_still_share_out_the_whole_region(shape, angle, spread):
    direction = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    left = np.array([-direction[1], direction[0]])
    even, drawn = (stripes(shape, direction, 15, 200.0, share) for share in (1.0, spread))
    at = [np.array([row.stretches[0][0] @ left for row in rows]) for rows in (even, drawn)]
    assert np.diff(at[1]) == pytest.approx(spread * np.diff(at[0]))
    # The outermost serve all beyond them: bands as wide as that cover the region.
    reach = np.ptp(np.array(shape.exterior.coords) @ left) - np.ptp(at[1])
    lines = [LineString(s) for row in drawn for s in row.stretches]
    swaths = unary_union([line.buffer(reach / 2 + 15, cap_style="flat") for line in lines])
    assert shape.difference(swaths.buffer(1.1e-3)).area < 1e-3

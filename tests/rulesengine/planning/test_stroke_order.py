"""The order of strokes: what is free is chosen, what is fixed stays, rings are unrolled where they are entered."""

import numpy as np
import pytest

from rulesengine.planning.stroke_order import order_strokes
from rulesengine.strokes.stroke import Stroke, StrokeSet
from specs.source import Source

HOME = np.zeros(3)
DOWN = np.array([0.0, 0.0, -1.0])


def line(x, y, length=10.0, **changes):
    """A line along +x at a height of 20."""
    tcp = np.array([[x, y, 20.0], [x + length, y, 20.0]])
    return stroke(tcp, made_by=Source.parse(f"line {x:g} {y:g}"), **changes)


def square(x, y, size=10.0, **changes):
    tcp = np.array([[x, y, 20], [x + size, y, 20], [x + size, y + size, 20], [x, y + size, 20]], dtype=float)
    return stroke(tcp, **({"closed": True, "laps": 2, "entries": (0, 1, 2, 3), "made_by": "ring"} | changes))


def stroke(tcp, **changes):
    count = len(tcp)
    known = {"delays": np.zeros(count), "speed_mm_s": 40.0, "made_by": "path"} | changes
    return Stroke(tcp=tcp, approach=np.tile(DOWN, (count, 1)), azimuth=np.tile([1.0, 0.0], (count, 1)), **known)


def ordered(strokes, freedom, start=HOME):
    return order_strokes(StrokeSet(tuple(strokes), freedom), start, "sequence[0]/path")


def names(result):
    return [str(each.made_by) for each in result.strokes]


def air_mm(result, start=HOME):
    ends = [start, *(each.tcp[-1] for each in result.strokes)]
    return sum(float(np.linalg.norm(each.tcp[0] - end)) for each, end in zip(result.strokes, ends, strict=False))


def test_nothing_is_ordered_into_nothing():
    for freedom in ("free", "either_end", "fixed"):
        assert ordered([], freedom).strokes == ()


def test_free_strokes_are_done_with_the_least_way_between_them():
    far_first = [line(0, y, sense="either") for y in (60, 20, 40, 0, 80)]
    done = ordered(far_first, "free")
    assert names(done) == [f"line 0 {y}" for y in (0, 20, 40, 60, 80)]
    assert air_mm(done) == pytest.approx(20 + 4 * 20)
    (finding,) = done.findings
    assert finding.rule.id == "order-gain"
    assert "100 mm between them instead of 243 mm in the given order (59 % less)" in finding.message
    assert str(finding.made_by) == "sequence[0]/path"


def test_fixed_order_stays_and_a_turnable_line_begins_at_its_nearer_end():
    done = ordered([line(0, 40), line(0, 0, sense="either"), line(0, 20)], "fixed")
    assert names(done) == ["line 0 40", "line 0 0", "line 0 20"]
    assert [each.tcp[0, 0] for each in done.strokes] == [0, 10, 0]
    assert done.findings == ()


def test_either_end_begins_with_the_nearer_of_first_and_last():
    rows = [line(0, y) for y in (0, 20, 40)]
    assert names(ordered(rows, "either_end")) == ["line 0 0", "line 0 20", "line 0 40"]
    assert names(ordered(rows, "either_end", np.array([0.0, 50.0, 20.0])))[0] == "line 0 40"


def test_last_bits_do_not_decide():
    rows = [line(0, -20), line(0, 20 - 1e-9)]
    assert names(ordered(rows, "either_end", np.array([0.0, 0.0, 20.0])))[0] == "line 0 -20"
    ring = square(-5, -5)
    for nudge in (-1e-9, 1e-9):
        (done,) = ordered([ring], "fixed", np.array([nudge, nudge, 20.0])).strokes
        np.testing.assert_allclose(done.tcp[0], ring.tcp[0])


def test_a_turned_line_is_the_same_line_backwards():
    there = line(0, 0, sense="either", delays=np.array([0.0, 0.7]), pauses=("", "U1"))
    (back,) = ordered([there], "fixed", np.array([10.0, 0.0, 20.0])).strokes
    np.testing.assert_array_equal(back.tcp, there.tcp[::-1])
    assert back.delays.tolist() == [0.7, 0.0]
    assert back.pauses == ("U1", "")


def test_a_ring_is_entered_where_it_is_nearest_and_closed_after_all_its_laps():
    (done,) = ordered([square(0, 0)], "free", np.array([12.0, 13.0, 20.0])).strokes
    assert not done.closed
    assert done.laps == 1
    np.testing.assert_array_equal(done.tcp[0], [10, 10, 20])
    np.testing.assert_array_equal(done.tcp[-1], done.tcp[0])
    assert len(done.tcp) == 2 * 4 + 1


def test_the_pause_at_the_entry_of_a_ring_is_made_on_arrival_only():
    (done,) = ordered([square(0, 0, delays=np.full(4, 0.5))], "fixed").strokes
    assert done.delays.tolist() == [0.0, *[0.5] * 8]


def test_a_ring_that_turns_where_it_closes_is_closed_by_that_turn():
    corners = square(0, 0).tcp
    turning = stroke(
        np.vstack([corners, corners[0] + np.array([0, 0, 1e-9])]),  # a raised ring closes but for the last bits
        closed=True,
        laps=3,
        delays=np.array([0, 0.2, 0.2, 0.2, 0.2]),
    )
    (done,) = ordered([turning], "fixed").strokes
    assert len(done.tcp) == 15
    assert done.delays.sum() == pytest.approx(3 * 4 * 0.2)
